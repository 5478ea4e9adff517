"""What a sensor at a fixed place sees of a train whose planets pass it: lines, families, signal."""
