"""Steady response with teeth that part and touch again on either flank: harmonic balance with alternating frequency
and time domain [cameron1989], continuation over speed, Floquet stability, shaft orders on a torus of phases.
"""
