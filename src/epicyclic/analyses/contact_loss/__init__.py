"""Steady response with teeth that part and touch again, on either flank: alternating frequency and time."""
