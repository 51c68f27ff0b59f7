"""Contact and flat-punch problems on a grid: conjugate gradients on the active set, coarse levels."""
