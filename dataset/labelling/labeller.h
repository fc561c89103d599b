// Labels of a scan from start labels and strokes: prepared once, solved anew after each stroke.
//
// Energy of the labels l over faces f and the pairs of faces (f, g) that meet:
//   sum_f A_f [ -k_colour log G_l(f) - k_walk log X_l(f) ] + k_border sum_fg b_fg w_fg M(l_f, l_g)
// A area, b length of the shared border (so that the mesh's fineness does not matter), G the probability by
// the person's own colour models (Rother et al., "GrabCut", SIGGRAPH 2004, on a mesh), X the random walker's,
// w the likeness of the two faces, M the distance of the classes. Stroked faces keep their class.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dataset/labelling/doubt.h"
#include "dataset/labelling/face_features.h"
#include "dataset/labelling/garment_questions.h"
#include "dataset/labelling/label_model.h"
#include "dataset/labelling/piece_cues.h"
#include "dataset/labelling/random_walker.h"
#include "dataset/labelling/start_labels.h"
#include "dataset/labelling/stroke_reach.h"
#include "dataset/labelling/strokes.h"

namespace ohb::labelling {

/// Which parts of the energy count: all for use, fewer for comparisons.
struct LabelTerms {
  bool colour = true;    // G
  bool prior = true;     // X
  bool walk = true;      // X is walked; without, it is the start labels
  bool reach = true;     // strokes change the start labels of all that they reach (see reach_of_stroke)
  bool border = true;    // M
  bool likeness = true;  // w; without, 1 everywhere
};

struct Labelling {
  std::vector<uint8_t> face_class;
  std::vector<float> confidence;  // probability that the class is right, see confidence_of
  std::vector<float> lead;        // see leads_of
  std::vector<bool> is_in_doubt;  // less sure than kDoubtful, or of a garment that is asked about
  std::vector<GarmentQuestion> questions;
  std::optional<SuggestedStroke> suggested;
  std::vector<std::string> warnings;
};

class Labeller {
 public:
  /// Reads the pictures and builds the graph. Throws InputError for a picture that cannot be read.
  /// `leather_share`: see LabelModel.
  explicit Labeller(const ScanSurface& surface, LabelTerms terms = {}, float leather_share = kLeatherShare);
  /// The same from features that are there already, with what was learned from other people. `unit_cm`: cm a
  /// unit of the scan.
  Labeller(FaceFeatures features, double unit_cm, LabelModel model, LabelTerms terms = {});

  /// Labels for all these strokes (none: from the start labels alone). They must fit the scan (see
  /// expect_stroke_on_scan). Starts from the result of the call before, which saves time; the first call's
  /// result depends on the arguments alone, and on no number of threads.
  Labelling solve(const std::vector<Stroke>& strokes);

  const FaceFeatures& features() const { return features_; }
  const StartLabels& start() const { return start_; }
  const Garments& garments() const { return garments_; }
  const std::vector<PieceCues>& piece_cues() const { return piece_cues_; }
  double unit_cm() const { return unit_cm_; }

 private:
  /// Skin, hair or garment of each face, and the garments.
  void find_parts();
  void take_patches_for_what_surrounds_them(std::vector<uint8_t>& part);
  std::vector<ClassValues> start_of_faces(const std::vector<ClassValues>& classes) const;
  std::vector<bool> told_faces(const std::vector<ClassValues>& classes, const StrokedFaces& stroked) const;
  void trust_garments(const std::vector<ClassValues>& classes, Labelling& labels) const;
  std::vector<ClassValues> revised_start(const std::vector<ClassValues>& first,
                                         const std::vector<Stroke>& strokes);
  /// What each stroke's reach counts: its class's share of the votes of all strokes on the faces that it
  /// covers, so that one against many speaks little for look-alikes; and less for a dot of a few mm.
  std::vector<float> reach_weights() const;
  std::vector<ClassValues> colour_probability(const std::vector<ClassValues>& share,
                                              const StrokedFaces& stroked) const;
  LabelEnergy energy_of_faces(const std::vector<ClassValues>& walk, const StrokedFaces& stroked) const;

  double unit_cm_;
  LabelTerms terms_;
  LabelModel model_;
  FaceFeatures features_;
  StartLabels start_;
  Garments garments_;
  std::vector<PieceCues> piece_cues_;
  std::vector<ClassValues> garment_classes_;  // before any stroke
  std::vector<uint8_t> start_class_;          // the likeliest
  std::vector<float> likeness_;               // of the edges
  std::vector<EnergyPair> borders_;
  std::optional<RandomWalker> walker_;
  struct Reach {
    Stroke stroke;
    float sharpness;  // the power of the likeness
    std::vector<uint32_t> covered;
    std::vector<StrokeLikeness> faces;
  };
  std::vector<Reach> reaches_;       // of the call before, in the order of its strokes
  std::vector<ClassValues> walk_;    // of the call before
  std::vector<uint8_t> face_class_;  // of the call before
};

/// The stroke that answers for a garment: a dot in its middle.
Stroke stroke_of_answer(const Labeller& labeller, size_t garment, MaterialClass material_class);

}  // namespace ohb::labelling
