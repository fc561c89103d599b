"""What both models of reflection show of a white room, integrated here by their formulas (docs/conventions.md, "Two models of
reflection"): a stand-in for neither Blender nor the add-on's fits. Cosines are those of the viewer and in (0, 1]."""
import math

STEPS = 48


def middles(count):
    return [(i + 0.5) / count for i in range(count)]


def burley(cosine, roughness):
    """Principled v1's diffuse of albedo 1: cosine-weighted mean of Burley's lobe (Burley 2012)."""
    sine, seen, total = math.sqrt(1 - cosine * cosine), (1 - cosine) ** 5, 0.0
    for x in middles(STEPS):
        c = math.sqrt(x)   # uniform in c^2: weighted by the cosine
        lit = (1 - c) ** 5
        for turn in middles(STEPS // 2):
            back = roughness * (1 + c * cosine + math.sqrt(1 - x) * sine * math.cos(math.pi * turn))
            total += (1 - 0.5 * seen) * (1 - 0.5 * lit) + back * (lit + seen + lit * seen * (back - 1))
    return total / (STEPS * (STEPS // 2))


def fresnel(cosine, f0):
    """Exact, of a dielectric with that reflectance at normal incidence."""
    eta = 2 / (1 - math.sqrt(f0)) - 1
    g = math.sqrt(eta * eta - 1 + cosine * cosine)
    a, b = (g - cosine) / (g + cosine), (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)
    return 0.5 * a * a * (1 + b * b)


def smith(cosine, roughness):
    """Lambda of GGX, alpha = roughness^2 (Heitz 2014)."""
    return 0.5 * (math.sqrt(1 + roughness ** 4 * (1 / (cosine * cosine) - 1)) - 1)


def highlight(cosine, roughness, f0, is_separable, reflect=fresnel):
    """GGX of one bounce in a white room, over facets h of density D: f cos = D F G / (4 cos). The slopes' tangent t is
    drawn so that D (n.h) is even."""
    alpha, sine, total = roughness * roughness, math.sqrt(1 - cosine * cosine), 0.0
    lambda_o, turns = smith(cosine, roughness), 2 * STEPS
    for u in middles(4 * STEPS):
        slope = alpha * math.sqrt(u / (1 - u))
        z = 1 / math.sqrt(1 + slope * slope)
        for turn in middles(turns):
            on_facet = cosine * z + sine * slope * z * math.cos(math.pi * turn)
            out = 2 * on_facet * z - cosine
            if on_facet > 0 and out > 0:
                lambda_i = smith(min(out, 1.0), roughness)
                masking = (1 + lambda_o) * (1 + lambda_i) if is_separable else 1 + lambda_o + lambda_i
                total += reflect(on_facet, f0) * on_facet / (masking * cosine * z)
    return total / (4 * STEPS * turns)


def layer(cosine, roughness, f0):
    """Principled v2's share of light that does not get below its highlight: F0, and what Fresnel's reflectance is above it
    (Cycles 4.x: for GGX of one bounce, F0 is not lessened by what facets hide)."""
    return f0 + highlight(cosine, roughness, f0, False, lambda c, f: fresnel(c, f) - f)
