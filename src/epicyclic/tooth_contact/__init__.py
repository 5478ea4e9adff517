"""Loaded tooth contact analysis of one pair of gears: contact lines, compliance of the teeth, unilateral contact.

Depends on: gears.
"""
