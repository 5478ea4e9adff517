"""What a train is, and what each analysis still asks of it."""
