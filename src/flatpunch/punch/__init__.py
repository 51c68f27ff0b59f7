"""The rigid cylindrical flat punch on a medium: one small matrix per harmonic, from which everything else follows."""
