"""What the page says of a train: five answers, failing checks, levers, assumed deviations, jobs that need longer."""
