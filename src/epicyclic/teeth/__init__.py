"""What a tooth is and what it does under load: geometry, micro-geometry, grades, compliance, contact, root stress."""
