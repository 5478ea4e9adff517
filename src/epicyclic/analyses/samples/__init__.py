"""Many trains that differ a little, at one speed: what tolerances do to the steady response, linear contact."""
