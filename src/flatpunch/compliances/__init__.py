"""Surface compliance: medium -> C(k), the displacement per pressure at wavenumber k."""

__all__ = ["Kernel", "compliance"]
from flatpunch.compliances.kernel import Kernel, compliance
