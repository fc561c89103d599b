# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's Principled BSDF of 4.0 and later has to be given for the picture that samples are rendered with. No bpy.

Samples are Principled v1 (docs/conventions.md): Burley's diffuse, with the highlight added to it. Principled v2 has
Lambert below the highlight's layer, which gets what the layer does not reflect towards the viewer: 3 to 6 % darker seen
from the front, up to 30 % at the rim. The highlights of both (GGX of one bounce) are the same to 1 or 2 %. So v2's albedo is
v1's times

    gain = (v1's diffuse) / (1 - v2's layer), both as seen in a white room.

Fits over the cosine of the viewer (.03 to 1) and roughness (.1 to 1), F0 up to .2, weighted by the area that such angles
take in a picture; tests/addon/unit/test_balance.py integrates both models and says how far they are off.
"""

#: v1's diffuse = a polynomial of the roughness + (1 - cosine)^5 x another
DIFFUSE, DIFFUSE_RIM, DIFFUSE_POWER = (0.9762, 0.0602), (-0.5045, 1.0964), 5
#: v2's layer = F0 + (1 - cosine)^3 x a polynomial of the roughness
LAYER_RIM, LAYER_POWER = (0.7688, -1.5330, 0.8098), 3
MOST_LAYER = 0.7   # of smooth surfaces at the very rim, beyond the fits


def polynomial(coefficients, x):
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value


def gain(cosine, roughness, f0):
    rim = 1 - cosine
    diffuse = polynomial(DIFFUSE, roughness) + rim ** DIFFUSE_POWER * polynomial(DIFFUSE_RIM, roughness)
    layer = f0 + rim ** LAYER_POWER * polynomial(LAYER_RIM, roughness)
    return diffuse / (1 - min(layer, MOST_LAYER))
