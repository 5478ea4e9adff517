"""Natural frequencies, shapes, kinds and energies; the modal basis that every other analysis stands on."""
