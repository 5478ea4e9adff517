"""Teeth that part and touch again on either flank."""
