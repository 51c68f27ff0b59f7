"""Second road to the fields of a load wave: Airy's stress function in every layer, all layers in one system, 32 digits."""

import mpmath as mp

mp.mp.dps = 32


def layer_rows(mu, nu, s):
    """Rows (k u_l, k u_z, s_lz, s_zz) at local depth s = kz of phi = (A + B s) e^-s + (C + D s) e^s, over k^2."""
    down, up = mp.exp(-s), mp.exp(s)
    # phi and its first three derivatives by s, for the four constants
    phi = [down, s * down, up, s * up]
    d1 = [-down, (1 - s) * down, up, (1 + s) * up]
    d2 = [down, (s - 2) * down, up, (s + 2) * up]
    d3 = [-down, (3 - s) * down, up, (s + 3) * up]
    s_ll, s_zz, s_lz = d2, [-p for p in phi], list(d1)
    # phi goes with cos(kl): s_lz = -phi_lz = phi_s sin(kl)
    u_l = [((1 - nu) * a - nu * b) / (2 * mu) for a, b in zip(s_ll, s_zz, strict=True)]
    slope = [((1 - nu) * a + nu * b) / (2 * mu) for a, b in zip(d3, d1, strict=True)]
    u_z = [a - b / mu for a, b in zip(slope, s_lz, strict=True)]
    return [u_l, u_z, s_lz, s_zz], s_ll


def solve(layers, base, k, load):
    """Constants of all layers: layers of (mu, nu, h, bonded), base (mu, nu) or None; load (s_lz, s_zz) at the surface."""
    n = len(layers)
    size = 4 * n + (2 if base else 0)
    matrix, right = mp.zeros(size, size), mp.zeros(size, 1)
    row = 0

    def put(r, column, values, sign=1):
        for j, value in enumerate(values):
            matrix[r, column + j] += sign * value

    top = layer_rows(layers[0][0], layers[0][1], mp.mpf(0))[0]
    put(0, 0, top[2])
    put(1, 0, top[3])
    right[0], right[1] = load
    row = 2
    for i, (mu, nu, h, bonded) in enumerate(layers):
        above = layer_rows(mu, nu, mp.mpf(k) * h)[0]
        if i + 1 < n:
            below, width = layer_rows(layers[i + 1][0], layers[i + 1][1], mp.mpf(0))[0], 4
        elif base:
            below, width = layer_rows(base[0], base[1], mp.mpf(0))[0], 2
        else:
            below, width = None, 0
        if below is None:
            put(row, 4 * i, above[1])
            put(row + 1, 4 * i, above[0] if bonded else above[2])
            row += 2
            continue
        if bonded:
            wanted = [(0, True), (1, True), (2, True), (3, True)]
        else:
            wanted = [(1, True), (3, True), (2, False)]
        for which, both in wanted:
            put(row, 4 * i, above[which])
            if both:
                put(row, 4 * i + 4, below[which][:width], -1)
            row += 1
        if not bonded:
            put(row, 4 * i + 4, below[2][:width])
            row += 1
    return mp.lu_solve(matrix, right)


def state(constants, layers, base, k, layer, depth):
    """k u_l, k u_z, s_lz, s_zz, s_ll at `depth` below the top of `layer`, from the constants of `solve`."""
    mu, nu = (layers[layer][:2]) if layer < len(layers) else base
    rows, along = layer_rows(mu, nu, mp.mpf(k) * depth)
    width = 4 if layer < len(layers) else 2
    c = [constants[4 * layer + j] for j in range(width)]
    return [float(sum(a * b for a, b in zip(row[:width], c, strict=True))) for row in [*rows, along]]
