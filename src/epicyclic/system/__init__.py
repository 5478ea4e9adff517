"""The System: matrices, gaps with laws, exact excitation lines; and its assembly from a Train.

Depends on: train, teeth.  Modules of the equation itself import neither, and analyses import those alone.
"""
