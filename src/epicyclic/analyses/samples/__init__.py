"""Many trains that differ a little: what tolerances do to the steady response at one speed, and to load sharing."""
