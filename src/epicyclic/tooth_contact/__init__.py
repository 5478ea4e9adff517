"""Loaded teeth of one pair of gears: lines of contact, compliance, and the load that unilateral contact leaves."""
