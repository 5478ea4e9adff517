"""Teeth in contact: lines of contact, compliance, and the load that unilateral contact leaves on them."""
