"""Kernels for other codes: what layered and graded bodies do under waves of traction, as plain arrays.

Importing this room loads NumPy and nothing else of the package; the physics is loaded by the first call. All media of the package
are taken, and plain tuples in their place (`surface_compliance` has the forms).

Conventions
-----------
==================  =================================================================================================
axes                x, y along the surface, z into the material, the surface is z = 0
Fourier sign        f(x, y) = f exp(i (qx x + qy y)); with NumPy's FFT, qx = 2 pi numpy.fft.fftfreq(n, spacing)
traction            force per area on the body: t_z > 0 is a pressure, t_x > 0 pulls along x
displacement        u_z > 0 is inward; u = C t, index i of C[..., i, j] is that of u, j that of t
stress              positive in tension: s_zz = -t_z, s_xz = -t_x at the surface
symmetry            C is Hermitian (reciprocity) and C(-q) the complex conjugate of C(q); normal and in-plane directions are
                    coupled by imaginary entries, C_xz = i d q_x/|q|; d > 0 on isotropic half-spaces with nu < 1/2: what is
                    next to a pressure moves towards it
q = 0               layers on a rigid base: uniform traction in a cell that does not stretch, C_zz the sum of thickness/C33,
                    C_xx that of thickness/C44; where that is infinite (elastic bases, sliding layers) the value of
                    `undetermined`
lower faces         bonded: displacement and traction continuous; sliding: no shear traction, u_z and s_zz continuous;
                    Interface: traction = stiffness times jump, less below a membrane by what it carries; a rigid base does
                    not move; no lift-off anywhere
two bodies          displacement of the lower surface less that of the upper, traction on the lower one
==================  =================================================================================================
"""

from flatpunch.kernels.inside import interior
from flatpunch.kernels.surface import influence_coefficients, normal_compliance, surface_compliance, surface_stiffness

__all__ = ["influence_coefficients", "interior", "normal_compliance", "surface_compliance", "surface_stiffness"]
