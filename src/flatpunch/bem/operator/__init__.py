"""From cell pressures to displacements: influence coefficients and convolution by FFT."""
