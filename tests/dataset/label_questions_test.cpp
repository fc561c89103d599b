// Labels that know their doubt: garments, questions, answers, and what a confidence claims.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "dataset/commands/label.h"
#include "dataset/labelling/enclosed_patches.h"
#include "dataset/labelling/labeller.h"
#include "dataset/model/atomic_file.h"
#include "dataset/model/data_files.h"
#include "tests/support/shared_data.h"
#include "tests/support/tube_person.h"

namespace ohb {
using namespace commands;
using namespace labelling;
using namespace surface;
namespace {

/// Repaints what is between two heights, all around.
void dress(TubePerson& person, double low_cm, double high_cm, Vec3f srgb, MaterialClass material_class) {
  Image picture = read_image(person.folder / "tube.png");
  for (int y = 0; y < picture.height_px; ++y) {
    const double height = kTubeHeight_cm * (1 - (y + 0.5) / picture.height_px);
    if (height < low_cm || height > high_cm) continue;
    for (int x = 0; x < picture.width_px; ++x) {
      const float grain = 0.01f * static_cast<float>((x * 7919 + y * 104729) % 101 - 50) / 50;
      for (int c = 0; c < 3; ++c) picture.pixel(x, y)[c] = srgb[c] + grain;
    }
  }
  write_png(person.folder / "tube.png", picture);
  const FaceGraph graph = face_graph({person.scan, 1});
  for (size_t f = 0; f < graph.size(); ++f)
    if (graph.centre_cm[f].y > low_cm && graph.centre_cm[f].y < high_cm) person.truth[f] = material_class;
}

double accuracy_of(const Labelling& labels, const TubePerson& person) {
  return compare_with_truth(labels.face_class, person.truth, face_areas(person.scan)).accuracy;
}

const GarmentQuestion* question_at(const Labelling& labels, const Labeller& labeller, uint32_t face) {
  for (const GarmentQuestion& question : labels.questions)
    if (labeller.garments().of_face[face] == question.garment) return &question;
  return nullptr;
}

/// A garment of 4.2 % of the area.
std::vector<GarmentQuestion> questions_about_small(MaterialClass now, float probability) {
  Garments garments;
  garments.all_cm2 = 10000;
  garments.garments = {{"socks", 420}};
  ClassValues classes{};
  classes[now] = probability;
  classes[now == kLeather ? kFabric : kLeather] = 1 - probability;
  return open_questions(garments, {classes});
}

TEST(LabelQuestions, ASmallGarmentIsAskedAboutIfColourAloneMakesItLeather) {
  EXPECT_EQ(questions_about_small(kLeather, 0.85f).size(), 1u);
  EXPECT_EQ(questions_about_small(kLeather, 0.95f).size(), 1u);
  EXPECT_EQ(questions_about_small(kFabric, 0.85f).size(), 0u) << "an answer would mend .6 % of the area";
  EXPECT_EQ(questions_about_small(kFabric, 0.75f).size(), 1u) << "1.05 %";
  EXPECT_EQ(questions_about_small(kLeather, 0.999f).size(), 0u) << "somebody said so";
}

/// The kind that came out 37 % wrong and .95 sure: nothing but the user can know.
TEST(LabelQuestions, LeatherTrousersOfAnyColourAreAskedAboutAndOneAnswerTellsThem) {
  const Vec3f colours[] = {
      {0.10f, 0.08f, 0.07f}, {0.05f, 0.05f, 0.05f}, {0.85f, 0.84f, 0.82f}, {0.55f, 0.08f, 0.08f}};
  double least = 1;
  for (const Vec3f& colour : colours) {
    TubePerson person;
    make_tube_person(48, 120, person);
    dress(person, 7, 85, colour, kLeather);
    Labeller labeller({person.scan, 1});
    const Labelling labels = labeller.solve({});
    const uint32_t knee = 30 * 48 + 24, chest = 85 * 48 + 24;
    const GarmentQuestion* question = question_at(labels, labeller, knee);
    ASSERT_TRUE(question) << colour.x;
    EXPECT_EQ(question->name, "trousers");
    EXPECT_NEAR(question->area_cm2, 78 * 2 * 3.1416 * 12, 400);
    EXPECT_LT(labels.confidence[knee], 0.971f) << "no look excludes leather";
    EXPECT_EQ(std::min(question->now, question->rival), kFabric);
    EXPECT_EQ(std::max(question->now, question->rival), kLeather);
    const Labelling answered = labeller.solve({stroke_of_answer(labeller, question->garment, kLeather)});
    EXPECT_EQ(question_at(answered, labeller, knee), nullptr) << "what is told is not asked again";
    EXPECT_GT(answered.confidence[knee], kDoubtful);
    EXPECT_EQ(answered.face_class[chest], kFabric);
    EXPECT_GT(accuracy_of(answered, person), 0.97);
    least = std::min(least, accuracy_of(labels, person));
  }
  EXPECT_LT(least, 0.7) << "else these people show nothing";
}

TEST(LabelQuestions, ComeLargestFirstAndBothAnswersAreHeard) {
  TubePerson person;
  make_tube_person(48, 120, person);
  Labeller labeller({person.scan, 1});
  const std::vector<GarmentQuestion> questions = labeller.solve({}).questions;
  ASSERT_GE(questions.size(), 2u);
  EXPECT_LE(questions.size(), kMostQuestions);
  for (size_t i = 1; i < questions.size(); ++i) EXPECT_LE(questions[i].area_cm2, questions[i - 1].area_cm2);
  const size_t garment = questions[0].garment;
  const uint32_t face = questions[0].face;
  EXPECT_EQ(labeller.solve({stroke_of_answer(labeller, garment, kLeather)}).face_class[face], kLeather);
  EXPECT_EQ(labeller.solve({stroke_of_answer(labeller, garment, kFabric)}).face_class[face], kFabric);
  EXPECT_EQ(labeller.solve({stroke_of_answer(labeller, garment, kHair)}).face_class[face], kHair);
}

TEST(LabelQuestions, AStrokeAgainstAnAnswerHoldsWhereItIs) {
  TubePerson person;
  make_tube_person(48, 120, person);
  Labeller labeller({person.scan, 1});
  const GarmentQuestion first = labeller.solve({}).questions.at(0);
  Stroke wrong = stroke_of_answer(labeller, first.garment, kFabric);
  const FaceGraph& graph = labeller.features().graph;
  for (uint32_t f = 0; f < graph.size(); ++f)
    if (labeller.garments().of_face[f] == first.garment &&
        std::abs(graph.centre_cm[f].y - graph.centre_cm[first.face].y) < 3 &&
        length(graph.centre_cm[f] - graph.centre_cm[first.face]) > 20)  // on the other side of the tube
      wrong.points = {{f, graph.centre_cm[f]}};
  wrong.time_s = 1;
  const Labelling labels = labeller.solve({stroke_of_answer(labeller, first.garment, kLeather), wrong});
  EXPECT_EQ(labels.face_class[first.face], kLeather);
  EXPECT_EQ(labels.face_class[wrong.points[0].face], kFabric);
}

/// The kind that turned a whole jacket: a small place of another class on a garment that is right.
TEST(LabelQuestions, AStrokeInAPlaceThatLooksOtherwiseTurnsThatPlaceAlone) {
  TubePerson person;
  make_tube_person(48, 120, person);
  dress(person, 40, 46, {0.75f, 0.15f, 0.15f}, kLeather);  // a belt of another colour around the knees
  const uint32_t belt = 30 * 48 + 24, thigh = 45 * 48 + 24, shin = 20 * 48 + 24;
  Labeller labeller({person.scan, 1});
  const Labelling before = labeller.solve({});
  Stroke stroke;
  stroke.material_class = kLeather;
  stroke.points = {{belt, labeller.features().graph.centre_cm[belt]}};
  const Labelling after = labeller.solve({stroke});
  EXPECT_EQ(before.face_class[thigh], kFabric);
  EXPECT_EQ(after.face_class[belt], kLeather);
  EXPECT_EQ(after.face_class[thigh], kFabric);
  EXPECT_EQ(after.face_class[shin], kFabric);
}

/// Trousers of the wearer's skin colour were skin, and nobody asked.
TEST(LabelQuestions, ClothesOfTheColourOfSkinAreAskedAbout) {
  TubePerson person;
  make_tube_person(48, 120, person);
  dress(person, 7, 85, {0.70f, 0.50f, 0.38f}, kFabric);
  Labeller labeller({person.scan, 1});
  const Labelling labels = labeller.solve({});
  const uint32_t knee = 30 * 48 + 24;
  const GarmentQuestion* question = question_at(labels, labeller, knee);
  ASSERT_TRUE(question);
  const Labelling answered = labeller.solve({stroke_of_answer(labeller, question->garment, kFabric)});
  EXPECT_EQ(answered.face_class[knee], kFabric);
  EXPECT_GT(accuracy_of(answered, person), 0.95);
}

/// The kind that left the belt of a suit leather when both its halves had been answered.
TEST(LabelQuestions, ASmallGarmentIsAsTheAnsweredOneThatLooksLikeIt) {
  TubePerson person;
  make_tube_person(48, 120, person);
  dress(person, 7, 85, {0.10f, 0.08f, 0.07f}, kLeather);
  dress(person, 85, 140, {0.16f, 0.15f, 0.15f}, kFabric);
  Labeller labeller({person.scan, 1});
  Garments garments = labeller.garments();
  ASSERT_GE(garments.garments.size(), 2u);
  std::vector<ClassValues> classes(garments.garments.size(), ClassValues{0, 0, 0.4f, 0.6f});
  Garment belt = garments.garments[0];  // looks like the first, has no faces of its own
  belt.area_cm2 = 0.01f * static_cast<float>(garments.all_cm2);
  belt.is_shoe = false;
  garments.garments.push_back(belt);
  classes.push_back({0, 0, 0.4f, 0.6f});
  hear_strokes(labeller.features(), 1, garments, {stroke_of_answer(labeller, 0, kFabric)}, classes);
  EXPECT_GT(classes.back()[kFabric], 0.8f);
  classes.back() = {0, 0, 0.4f, 0.6f};
  garments.garments.back().look[0] += 60;
  hear_strokes(labeller.features(), 1, garments, {stroke_of_answer(labeller, 0, kFabric)}, classes);
  EXPECT_FLOAT_EQ(classes.back()[kFabric], 0.4f) << "it looks otherwise";
}

TEST(LabelQuestions, LeatherIsAsCommonAsIsStated) {
  TubePerson person;
  make_tube_person(48, 120, person);
  const uint32_t knee = 30 * 48 + 24;
  float before = 0;
  for (float share : {0.02f, 0.1f, 0.3f, 0.6f}) {
    Labeller labeller({person.scan, 1}, {}, share);
    const uint32_t g = labeller.garments().of_face[knee];
    ASSERT_NE(g, Garments::kNone);
    const ClassValues p = piece_classes(labeller.garments().garments[g], labeller.piece_cues()[g],
                                        installed_label_model().pieces, share);
    EXPECT_GE(p[kLeather], before);
    EXPECT_LE(p[kFabric], 0.9701f) << "no look excludes leather";
    before = p[kLeather];
  }
  EXPECT_GT(before, 0.1f);
}

/// Soles of the colour of skin under shoes were skin; palms of dark hands were cloth.
TEST(LabelPatches, SolesAreOfTheirShoesAndPalmsAreSkin) {
  constexpr int kSide = 40;  // a sheet of 40 x 40 cm, its patch in the middle
  Scan scan;
  for (int z = 0; z <= kSide; ++z)
    for (int x = 0; x <= kSide; ++x)
      scan.positions.push_back({static_cast<float>(x), 0, static_cast<float>(z)});
  scan.face_begin.push_back(0);
  for (int z = 0; z < kSide; ++z)
    for (int x = 0; x < kSide; ++x) {
      const uint32_t v = static_cast<uint32_t>(z * (kSide + 1) + x);
      for (uint32_t corner : {v, v + 1, v + kSide + 2, v + kSide + 1}) scan.corners.push_back({corner});
      scan.face_begin.push_back(static_cast<uint32_t>(scan.corners.size()));
    }
  FaceFeatures features;
  features.graph = face_graph({scan, 1});
  BodyFrame frame;
  frame.top_cm = 170;
  const auto changes_of = [&](uint8_t around, uint8_t inside, float hue) {
    std::vector<uint8_t> part(features.size(), around);
    features.lab.assign(features.size(), {40, 15, 15});
    for (int z = 18; z < 22; ++z)
      for (int x = 18; x < 21; ++x) {
        part[static_cast<size_t>(z * kSide + x)] = inside;
        features.lab[static_cast<size_t>(z * kSide + x)] = {60, 15, 15 + hue};
      }
    return enclosed_patches(features, frame, part);
  };
  const std::vector<PartChange> palm = changes_of(kSkin, kFabric, 4), sole = changes_of(kFabric, kSkin, 4);
  ASSERT_EQ(palm.size(), 12u);
  EXPECT_EQ(palm[0].part, kSkin);
  ASSERT_EQ(sole.size(), 12u);
  EXPECT_EQ(sole[0].part, kFabric);
  EXPECT_TRUE(changes_of(kSkin, kFabric, 40).empty()) << "a plaster of another hue is none";
  frame.ground_cm = -100;
  EXPECT_TRUE(changes_of(kFabric, kSkin, 4).empty()) << "a neckline is no sole";
}

TEST(LabelModel, CalibrationIsLinearBetweenItsKnotsAndHoldsItsEnds) {
  const Calibration calibration{{-1, 1, 3}, {0.2f, 0.6f, 1}};
  EXPECT_FLOAT_EQ(calibrated(calibration, -5), 0.2f);
  EXPECT_FLOAT_EQ(calibrated(calibration, 0), 0.4f);
  EXPECT_FLOAT_EQ(calibrated(calibration, 2), 0.8f);
  EXPECT_FLOAT_EQ(calibrated(calibration, 9), 1);
}

TEST(LabelModel, PartsAreASoftmaxOfTheirCues) {
  LabelModel model;
  Cues cues{};
  cues[0] = 1;
  cues[1] = 0.5f;
  model.part_weights[kSkin][0] = 1;
  model.part_weights[kSkin][1] = 2;
  model.part_weights[kHair][1] = -4;
  const PartValues p = part_probability(model, cues);
  const double sum = std::exp(2.0) + std::exp(-2.0) + 1;
  EXPECT_NEAR(p[kSkin], std::exp(2.0) / sum, 1e-6);
  EXPECT_NEAR(p[kHair], std::exp(-2.0) / sum, 1e-6);
  EXPECT_NEAR(p[kGarment], 1 / sum, 1e-6);
}

TEST(LabelModel, ReadsWhatItWroteAndRefusesWhatIsNoModel) {
  const TemporaryFolder folder;
  const LabelModel& model = installed_label_model();
  const std::string text = label_model_json(model);
  const LabelModel again = read_label_model(write_bytes(folder / "m.json", text));
  EXPECT_EQ(label_model_json(again), text);
  const auto refused = [&](nlohmann::json json, std::vector<std::string> words) {
    const std::filesystem::path file = write_bytes(folder / "bad.json", json.dump());
    const std::string message = input_error_of([&] { read_label_model(file); });
    words.push_back("bad.json");
    for (const std::string& word : words) expect_message(message, {word});
  };
  nlohmann::json json = nlohmann::json::parse(text);
  json["skin"].erase("face");
  refused(json, {"skin", "weights"});
  json = nlohmann::json::parse(text);
  json["calibration"]["hair"].front()["right"] = 1.5;
  refused(json, {"calibration of hair", "ascend"});
  json["calibration"].erase("hair");
  refused(json, {"calibration of hair", "no list"});
  json = nlohmann::json::parse(text);
  json["leather"]["brown"] = "often";
  refused(json, {"brown", "no number"});
  refused(nlohmann::json::array(), {"object"});
}

struct TubeJob {
  TubePerson person;
  LabelJob job;
  TubeJob() {
    make_tube_person(48, 120, person);
    dress(person, 7, 85, {0.10f, 0.08f, 0.07f}, kLeather);
    job.scan = write_tube_obj(person, "atlas");
    job.unit = "cm";
    job.automatic = true;
    job.output = person.folder / "regions";
  }
};

TEST(LabelQuestions, TheReportAsksAndAnAnswerIsAStrokeThatCanBeGivenAgain) {
  TubeJob tube;
  const LabelReport asked = label_scan(tube.job);
  ASSERT_TRUE(asked.inferred);
  const auto& questions = asked.inferred->questions;
  const auto trousers = std::find_if(questions.begin(), questions.end(),
                                     [](const QuestionReport& q) { return q.name == "trousers"; });
  ASSERT_NE(trousers, questions.end());
  const std::string text = read_file(tube.job.output / "report.txt");
  for (const std::string& part : {std::string("trousers,"), std::string("fabric or leather?"),
                                  std::string("--answer trousers=leather"), trousers->rival_stroke})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  EXPECT_NE(trousers->rival_stroke.find(" at=\""), std::string::npos);
  for (const char* file : {"preview_front.png", "preview_back.png", "preview.svg"})
    EXPECT_TRUE(std::filesystem::is_regular_file(tube.job.output / file)) << file;
  EXPECT_NE(read_file(tube.job.output / "preview.svg").find("trousers"), std::string::npos);
  EXPECT_GT(asked.inferred->doubtful_area, trousers->area_cm2 * 0.95);

  tube.job.answers = {"trousers=leather"};
  const LabelReport answered = label_scan(tube.job);
  const std::string faces = read_file(tube.job.output / "faces.txt");
  EXPECT_GT(answered.classes[kLeather].area, trousers->area_cm2 * 0.95);
  LabelJob again = tube.job;
  again.answers.clear();
  again.automatic = false;
  again.strokes = tube.person.folder / "strokes.xml";
  std::filesystem::copy_file(tube.job.output / "strokes.xml", again.strokes);
  label_scan(again);
  EXPECT_EQ(read_file(tube.job.output / "faces.txt"), faces);
  // The ready line is the same stroke.
  write_bytes(again.strokes, "<strokes schema=\"1.0\">" + trousers->rival_stroke + "</strokes>");
  std::filesystem::remove_all(tube.job.output);
  label_scan(again);
  EXPECT_EQ(read_file(tube.job.output / "faces.txt"), faces);
  // So does its number.
  tube.job.answers = {std::to_string(trousers - questions.begin() + 1) + "=leather"};
  label_scan(tube.job);
  EXPECT_EQ(read_file(tube.job.output / "faces.txt"), faces);
}

TEST(LabelQuestions, WrongAnswersAreRefusedInWordsAndWriteNothing) {
  TubeJob tube;
  const auto refused = [&](std::vector<std::string> answers, const std::vector<std::string>& words) {
    tube.job.answers = std::move(answers);
    const std::string message = input_error_of([&] { label_scan(tube.job); });
    for (const std::string& word : words) expect_message(message, {word});
    EXPECT_FALSE(std::filesystem::exists(tube.job.output));
  };
  refused({"hat=leather"}, {"hat=leather", "no question 'hat'", "trousers"});
  refused({"9=leather"}, {"no question '9'"});
  refused({"trousers"}, {"NAME=CLASS"});
  refused({"trousers=wool"}, {"NAME=CLASS", "trousers=leather"});
  refused({"trousers=leather", "trousers=fabric"}, {"trousers", "twice"});
  tube.job.automatic = false;
  refused({"trousers=leather"}, {"--answer", "--automatic"});
}

/// Measured, each person by what was learned from the others: see docs/measurements/label.md. Here by the
/// installed weights.
TEST(LabelQuestions, DressedHumansAreRightOnceTheyAreAnswered) {
  OHB_SHARED_DATA_OR_SKIP(folder, "humans");
  std::vector<double> answered;
  for (const std::filesystem::path& file : objs_below(folder)) {
    if (file.stem().string().find("_scan") == std::string::npos) continue;
    const Scan scan = read_scan(file);
    std::filesystem::path truth_file = file;
    truth_file.replace_extension(".labels.txt");
    const std::vector<uint8_t> truth =
        read_face_classes(truth_file, scan.face_count(), class_order_of(truth_file, file));
    const std::vector<double> areas = face_areas(scan);
    Labeller labeller({scan, 1});
    const Labelling labels = labeller.solve({});
    double wrong = 0, doubtful = 0, all = 0;
    for (size_t f = 0; f < areas.size(); ++f) {
      all += areas[f];
      if (labels.face_class[f] != truth[f]) wrong += areas[f];
      if (labels.is_in_doubt[f]) doubtful += areas[f];
    }
    EXPECT_LT(wrong, doubtful) << file << " of " << all;
    std::vector<Stroke> strokes;
    for (const GarmentQuestion& question : labels.questions) {
      std::array<double, kClassCount> of{};
      for (size_t f = 0; f < areas.size(); ++f)
        if (labeller.garments().of_face[f] == question.garment) of[truth[f]] += areas[f];
      const auto most = std::max_element(of.begin(), of.end()) - of.begin();
      strokes.push_back(stroke_of_answer(labeller, question.garment, static_cast<MaterialClass>(most)));
    }
    answered.push_back(compare_with_truth(labeller.solve(strokes).face_class, truth, areas).accuracy);
    EXPECT_GT(answered.back(), 0.98) << file;
  }
  ASSERT_FALSE(answered.empty());
  std::nth_element(answered.begin(), answered.begin() + answered.size() / 2, answered.end());
  EXPECT_GT(answered[answered.size() / 2], 0.995);
}

}  // namespace
}  // namespace ohb
