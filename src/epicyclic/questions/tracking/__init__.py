"""Natural frequencies followed over a parameter: loci, their derivatives and veering."""
