#include "dataset/commands/source_materials.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "dataset/model/colour.h"
#include "dataset/model/error.h"
#include "dataset/model/map_table.h"
#include "dataset/surface/picture.h"
#include "dataset/surface/vertex_colours.h"

namespace ohb::commands {
namespace {

int wrapped(int i, int size) {
  return (i % size + size) % size;
}

/// Bilinear lookups at the texels of a larger image; repeats.
Image looked_up(const Image& image, int width_px, int height_px) {
  if (image.width_px == width_px && image.height_px == height_px) return image;
  Image out(width_px, height_px, image.channels);
  tbb::parallel_for(0, height_px, [&](int y) {
    const double v = (y + 0.5) * image.height_px / height_px - 0.5;
    const int y0 = static_cast<int>(std::floor(v));
    for (int x = 0; x < width_px; ++x) {
      const double u = (x + 0.5) * image.width_px / width_px - 0.5;
      const int x0 = static_cast<int>(std::floor(u));
      for (int k = 0; k < 4; ++k) {
        const int dx = k & 1, dy = k >> 1;
        const double weight = (dx ? u - x0 : 1 - (u - x0)) * (dy ? v - y0 : 1 - (v - y0));
        const float* const from =
            image.pixel(wrapped(x0 + dx, image.width_px), wrapped(y0 + dy, image.height_px));
        for (int c = 0; c < image.channels; ++c) out.pixel(x, y)[c] += static_cast<float>(weight * from[c]);
      }
    }
  });
  return out;
}

/// Value v of each pixel as `convert(pixel, channels, v)`; `channels` of them.
template <class Convert>
Image converted(const Image& stored, int channels, Convert convert) {
  Image out(stored.width_px, stored.height_px, channels);
  tbb::parallel_for(0, stored.height_px, [&](int y) {
    for (int x = 0; x < stored.width_px; ++x)
      for (int c = 0; c < channels; ++c) out.pixel(x, y)[c] = convert(stored.pixel(x, y), stored.channels, c);
  });
  return out;
}

Image diffuse_of(const ScanMaterial& material) {
  const Vec3f factor = material.diffuse_factor;
  if (material.diffuse.empty()) {
    Image image(1, 1, 3);
    for (int c = 0; c < 3; ++c) image.values[static_cast<size_t>(c)] = factor[c];
    return image;
  }
  ImageFileInfo info;
  const Image stored = read_image(material.diffuse, &info);
  return converted(stored, 3, [&](const float* pixel, int channels, int c) {
    const float value = pixel[channels >= 3 ? c : 0];
    return factor[c] * (info.is_float ? value : srgb_to_linear(value));
  });
}

/// Without what the material multiplies it by.
Image alpha_of(const ScanMaterial& material) {
  if (material.is_opaque()) return {};
  if (material.alpha.empty()) {
    Image image(1, 1, 1);
    image.values[0] = 1;
    return image;
  }
  return surface::read_alpha_picture(material);
}

Image normal_of(const ScanMaterial& material, surface::GreenChannel green) {
  if (material.normal.empty()) return {};
  ImageFileInfo info;
  const Image stored = read_image(material.normal, &info);
  return converted(stored, 3, [&](const float* pixel, int, int c) {
    const float value = info.is_float ? pixel[c] : 2 * pixel[c] - 1;
    return c == 1 && green == surface::GreenChannel::kDown ? -value : value;
  });
}

/// The shares of the classes, in their order; empty without weights.exr.
Image shares_of(const std::filesystem::path& file) {
  if (file.empty()) return {};
  const std::vector<ExrPart> parts = read_exr(file);
  const ExrPart& part = find_part(parts, "weights", file);
  return converted(part.image, kClassCount, [&](const float* pixel, int, int c) {
    const auto at =
        std::find(part.channels.begin(), part.channels.end(), kClassNames[static_cast<size_t>(c)]);
    if (at == part.channels.end())
      throw InputError(file.string(), "", std::string("has no channel '") + kClassNames[c] + "'",
                       "run `label` again");
    return pixel[at - part.channels.begin()];
  });
}

/// What all classes of a material share, at the size of its largest picture.
struct Pictures {
  TextureSet set;  // without the values of the classes
  Image shares;
};

/// The colours at the vertices of a set's faces, and what the material makes of its alpha.
void multiply_by_vertices(const BakeInputs& inputs, const bake::CanonicalMesh& mesh, uint16_t material,
                          TextureSet& set) {
  const ScanMaterial& of = inputs.scan.materials[material];
  if (of.has_vertex_colours || of.has_vertex_alpha) {
    std::vector<std::array<uint32_t, 3>> corners;
    std::vector<surface::UvTriangle> uvs;
    for (const ScanTriangle& triangle : mesh.triangles) {
      if (inputs.scan.face_material[triangle.face] != material) continue;
      corners.push_back({triangle.corner[0], triangle.corner[1], triangle.corner[2]});
      uvs.emplace_back();
      for (size_t k = 0; k < 3; ++k)
        uvs.back().uv[k] = inputs.scan.uvs[inputs.scan.corners[triangle.corner[k]].uv];
    }
    const surface::TexelCoverage coverage =
        surface::cover_texels(uvs, set.albedo.width_px, set.albedo.height_px);
    surface::multiply_vertex_colours(inputs.scan, corners, uvs, coverage, set.albedo);
    if (of.has_vertex_alpha) surface::multiply_vertex_colours(inputs.scan, corners, uvs, coverage, set.alpha);
  }
  for (float& value : set.alpha.values) value = of.opacity_of(value);
}

Pictures pictures_of(const BakeInputs& inputs, const bake::CanonicalMesh& mesh, uint16_t material) {
  const ScanMaterial& of = inputs.scan.materials[material];
  const bake::BakeOptions& options = inputs.options;
  Pictures pictures;
  TextureSet& set = pictures.set;
  set.name = of.name;
  set.albedo = diffuse_of(of);
  set.alpha = alpha_of(of);
  set.normal = normal_of(of, options.green.empty() ? surface::GreenChannel::kUp : options.green[material]);
  if (!options.class_weights.empty()) pictures.shares = shares_of(options.class_weights[material]);
  int width = 1, height = 1;
  if (of.has_vertex_colours || of.has_vertex_alpha) width = height = bake::kSizeWithoutPicture_px;
  Image* const images[] = {&set.albedo, &set.alpha, &set.normal, &pictures.shares};
  for (const Image* image : images) {
    width = std::max(width, image->width_px);
    height = std::max(height, image->height_px);
  }
  for (Image* image : images)
    if (!image->values.empty()) *image = looked_up(*image, width, height);
  multiply_by_vertices(inputs, mesh, material, set);
  set.displacement = Image(width, height, 1);  // no renderer reads it
  set.valid = Image(width, height, 1);
  std::fill(set.valid.values.begin(), set.valid.values.end(), 1.0f);
  return pictures;
}

void set_class_values(TextureSet& set, const ClassMaterial& value) {
  const auto constant = [&](float v) {
    Image image(set.albedo.width_px, set.albedo.height_px, 1);
    std::fill(image.values.begin(), image.values.end(), v);
    return image;
  };
  for (const MaterialMap& map : kMaterialMaps) set.*map.texels = constant(value.*map.value);
}

/// Where the shares know a class: the values mixed by them. Elsewhere what set_class_values put there stays.
void mix_class_values(TextureSet& set, const Image& shares, const MaterialTable& table) {
  for (size_t i = 0; i < set.roughness.values.size(); ++i) {
    std::array<double, kMaterialMaps.size()> mixed{};
    double sum = 0;
    for (size_t c = 0; c < kClassCount; ++c) {
      const double share = shares.values[kClassCount * i + c];
      sum += share;
      for (size_t m = 0; m < mixed.size(); ++m) mixed[m] += share * table[c].*kMaterialMaps[m].value;
    }
    if (!(sum > 0)) continue;
    for (size_t m = 0; m < mixed.size(); ++m)
      (set.*kMaterialMaps[m].texels).values[i] = static_cast<float>(mixed[m] / sum);
  }
}

}  // namespace

Model source_material_model(const BakeInputs& inputs) {
  const bake::CanonicalMesh mesh = bake::canonical_mesh(inputs.scan, inputs.regions, inputs.options.unit_cm);
  Model model = mesh.model;
  model.name = inputs.options.name;
  std::vector<std::array<int, kClassCount>> set_of(
      model.sets.size());  // of each material and class; -1: none
  for (auto& numbers : set_of) numbers.fill(-1);
  for (const ModelTriangle& triangle : model.triangles) set_of[triangle.set][triangle.material_class] = 0;
  model.sets.clear();
  for (size_t m = 0; m < set_of.size(); ++m) {
    const Pictures pictures = pictures_of(inputs, mesh, mesh.material_of_set[m]);
    for (size_t c = 0; c < kClassCount; ++c) {
      if (set_of[m][c] < 0) continue;
      set_of[m][c] = static_cast<int>(model.sets.size());
      TextureSet set = pictures.set;
      set.name += std::string(".") + kClassNames[c];
      set_class_values(set, inputs.table[c]);
      if (!pictures.shares.values.empty()) mix_class_values(set, pictures.shares, inputs.table);
      model.sets.push_back(std::move(set));
    }
  }
  for (ModelTriangle& triangle : model.triangles)
    triangle.set = static_cast<uint16_t>(set_of[triangle.set][triangle.material_class]);
  return model;
}

int largest_picture_px(const Scan& scan) {
  int largest = 0;
  for (const ScanMaterial& material : scan.materials) {
    if (material.diffuse.empty()) continue;
    const ImageFileInfo info = probe_image(material.diffuse);
    largest = std::max({largest, info.width_px, info.height_px});
  }
  return largest > 0 ? largest : bake::kSizeWithoutPicture_px;
}

}  // namespace ohb::commands
