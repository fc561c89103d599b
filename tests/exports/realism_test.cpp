// The card's figure: each step changes the picture where the model has what it adds, and nowhere else.
#include "dataset/exports/realism.h"

#include <gtest/gtest.h>

#include "tests/support/test_files.h"
#include "tests/support/test_models.h"

namespace ohb::exports {
namespace {

constexpr int kCell_px = 48, kMap_px = 16;

/// A ball whose upper third is hair.
Model head_of_a_ball(const TestMaterial& material, bool has_normals) {
  TextureSet set = constant_set(material, kMap_px);
  // Walks take their time: light goes under the surface at two texels in front alone.
  for (int i = 0; i < kMap_px * kMap_px; ++i)
    if (i != kMap_px * kMap_px / 2 + 11 && i != kMap_px * kMap_px / 2 + 12)
      set.sss.values[static_cast<size_t>(i)] = 0;
  if (has_normals) {
    set.normal = Image(kMap_px, kMap_px, 3);
    for (size_t i = 0; i < set.normal.values.size(); i += 3)
      set.normal.values[i] = 0.6F, set.normal.values[i + 2] = 0.8F;
  }
  Model model = sphere_model(20, 24, set);
  for (ModelTriangle& triangle : model.triangles)
    if (model.positions_cm[triangle.position[0]].y > 27) triangle.material_class = kHair;
  return model;
}

/// Which of the four steps' columns differ from the one before: three digits.
std::string changes(const ByteImage& figure) {
  const auto differs = [&](int step) {
    for (int y = 0; y < figure.height_px; ++y)
      for (int x = 0; x < 2 * kCell_px; ++x) {
        const size_t here = static_cast<size_t>(y * figure.width_px + 2 * step * kCell_px + x) * 3;
        for (size_t c = 0; c < 3; ++c)
          if (figure.values[here + c] != figure.values[here - 6 * kCell_px + c]) return true;
      }
    return false;
  };
  std::string text;
  for (int step = 1; step < 4; ++step) text += differs(step) ? '1' : '0';
  return text;
}

std::string changes_of(const TestMaterial& material, bool has_normals) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "model");
  write_model(folder / "model", head_of_a_ball(material, has_normals));
  SampleIndex index;
  for (const char* id : {"ann", "bob", "cy"}) index.people.push_back({id, "train", {}, folder / "model"});
  index.people.push_back({"dan", "train", {}, folder / "gone"});
  const ByteImage figure = realism_figure(index, {kCell_px, 4}, true);
  EXPECT_EQ(figure.width_px, 8 * kCell_px);
  EXPECT_EQ(figure.height_px, 3 * kCell_px);
  return changes(figure);
}

TEST(Realism, EachStepChangesWhatItAdds) {
  EXPECT_EQ(changes_of({{0.8F, 0.4F, 0.2F}, 0.3F, 0.2F, 0.05F}, true), "111");
  EXPECT_EQ(changes_of({{0.8F, 0.4F, 0.2F}, 0.5F, 0.5F, 0.05F}, false), "010");
  EXPECT_EQ(changes_of({{0.8F, 0.4F, 0.2F}, 0.5F, 0.2F, 0}, false), "100");
}

TEST(Realism, NobodysModelNoFigure) {
  SampleIndex index;
  index.people = {{"ann", "train", {}, {}}, {"bob", "train", {}, {}}, {"cy", "train", {}, {}}};
  EXPECT_TRUE(realism_figure(index, {kCell_px, 4}, true).values.empty());
}

}  // namespace
}  // namespace ohb::exports
