// The medium under a surface, as Principled v1 of Blender 3.4 makes it from colour and radius.
#pragma once

#include "renderer/cycles_model.h"
#include "renderer/scene.h"

namespace ohb::renderer {

/// What a random walk needs to know, by channel.
struct SubsurfaceMedium {
  Vec3f sigma_t_per_cm;  // extinction
  Vec3f albedo;          // of one scattering event
  Vec3f entry_weight;    // factor on the throughput
  Vec3f relaxation_mfp;  // > 1: decay length of the diffuse mode in mean free paths (Dwivedi's nu)
};

/// Radius to mean free path at index of refraction 1.4 for a surface colour in [0, 1] by Jensen's dipole
/// (2001, equation for R_d): alpha' with R_d(alpha') = colour, then sqrt(3 (1 - alpha')). Cycles solves it by
/// twelve bisections, which is part of the picture: the factor is a staircase, 20 % off at colour 0.9.
float mean_free_path_a_radius(float colour);

/// Single-scattering albedo of a half-space of isotropic scatterers whose reflectance is `colour`: the fit
/// that Cycles uses at anisotropy 0.
float single_scattering_albedo(float colour);

/// Decay length of the diffuse mode in mean free paths for a single-scattering albedo in [0.2, 1); any value
/// above 1 keeps the walk unbiased. Fit of d'Eon, used by Krivanek and d'Eon, "A Zero-Variance-Based Sampling
/// Scheme for Monte Carlo Subsurface Scattering", 2014.
float relaxation_length_mfp(float albedo);

/// colour: linear albedo; radius_cm by channel, > 0.
SubsurfaceMedium subsurface_medium(Vec3f colour, Vec3f radius_cm);

/// The scattering radius where the subsurface map is `sss` (docs/conventions.md).
inline Vec3f subsurface_radius_cm(float sss) {
  return sss * Vec3f{1.0f, 0.2f, 0.1f};
}

}  // namespace ohb::renderer
