"""Vibration seen by a sensor at a fixed position while planets pass it: lines, families, signal."""
