"""Motion in time: run-up, torque steps, histories, from any start, with teeth that part."""
