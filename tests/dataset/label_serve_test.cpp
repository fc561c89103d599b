#include "dataset/commands/label_serve.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "dataset/commands/label.h"
#include "dataset/model/atomic_file.h"
#include "tests/support/scan_files.h"
#include "tests/support/tube_person.h"

namespace ohb {
using namespace commands;
using namespace labelling;
namespace {

using Json = nlohmann::json;

/// A tube person on disk, and the answers to lines of requests.
struct Conversation {
  TubePerson person;
  LabelServeJob job;

  Conversation() {
    make_tube_person(24, 60, person);
    job.scan = write_tube_obj(person, "atlas");
  }

  std::vector<Json> answers(const std::string& requests) const {
    std::istringstream in(requests);
    std::ostringstream out;
    serve_labels(job, in, out);
    std::istringstream lines(out.str());
    std::vector<Json> answers;
    for (std::string line; std::getline(lines, line);) answers.push_back(Json::parse(line));
    return answers;
  }

  /// A stroke at the middle of a face, as a request.
  std::string stroke_at(uint32_t face, const std::string& name, int id) const {
    Vec3f sum;
    for (uint32_t c = person.scan.face_begin[face]; c < person.scan.face_begin[face + 1]; ++c)
      sum += person.scan.positions[person.scan.corners[c].position];
    return Json{{"id", id},
                {"do", "stroke"},
                {"class", name},
                {"radius_cm", 1.5},
                {"points", {{face, sum.x / 4, sum.y / 4, sum.z / 4}}}}
               .dump() +
           "\n";
  }
};

void apply_changes(const Json& answer, std::vector<uint8_t>& face_class) {
  for (const Json& run : answer["changed"])
    for (size_t i = 0; i < run[1]; ++i) face_class.at(run[0].get<size_t>() + i) = run[2];
}

TEST(LabelServe, TellsWhatEachStrokeChangesAndTakesItBack) {
  const Conversation talk;
  const uint32_t trousers = 24 * 20 + 12;
  const auto answers =
      talk.answers(talk.stroke_at(trousers, "leather", 7) + "{\"do\":\"undo\",\"id\":\"x\"}\n");
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_TRUE(answers[0]["ready"]);
  EXPECT_EQ(answers[0]["faces"], 24 * 60);
  std::vector<uint8_t> face_class(24 * 60, kUnlabelled);
  apply_changes(answers[0], face_class);
  EXPECT_EQ(std::count(face_class.begin(), face_class.end(), kUnlabelled), 0);
  const std::vector<uint8_t> start = face_class;
  EXPECT_EQ(start[trousers], kFabric);
  EXPECT_EQ(answers[1]["id"], 7);
  EXPECT_EQ(answers[1]["strokes"], 1);
  apply_changes(answers[1], face_class);
  EXPECT_EQ(face_class[trousers], kLeather);
  EXPECT_GT(std::count(face_class.begin(), face_class.end(), kLeather), 300);
  EXPECT_EQ(answers[2]["id"], "x");
  EXPECT_EQ(answers[2]["strokes"], 0);
  apply_changes(answers[2], face_class);
  EXPECT_EQ(face_class, start);
}

TEST(LabelServe, WhatItSavesLabelsTheSameAgain) {
  const Conversation talk;
  const std::string file = (talk.person.folder / "s.xml").string();
  const auto answers =
      talk.answers(talk.stroke_at(24 * 20 + 12, "leather", 1) + Json{{"do", "save"}, {"file", file}}.dump() +
                   "\n{\"do\":\"quit\"}\nmore\n");
  ASSERT_EQ(answers.size(), 3u);  // nothing after quit
  std::vector<uint8_t> face_class(24 * 60, kUnlabelled);
  apply_changes(answers[0], face_class);
  apply_changes(answers[1], face_class);
  LabelJob label;
  label.scan = talk.job.scan;
  label.strokes = file;
  label.output = talk.person.folder / "regions";
  label_scan(label);
  EXPECT_EQ(read_regions(label.output).face_class, face_class);
}

TEST(LabelServe, AListOfStrokesReplacesThoseSoFar) {
  const Conversation talk;
  const Json leather = Json::parse(talk.stroke_at(24 * 20 + 12, "leather", 1));
  const std::string list = Json{{"do", "strokes"}, {"strokes", {leather}}}.dump() + "\n";
  const auto one = talk.answers(talk.stroke_at(24 * 20 + 12, "leather", 1));
  const auto other = talk.answers(talk.stroke_at(24 * 50, "hair", 1) + list);
  std::vector<uint8_t> expected(24 * 60), face_class(24 * 60);
  for (const Json& answer : one) apply_changes(answer, expected);
  for (const Json& answer : other) apply_changes(answer, face_class);
  EXPECT_EQ(other[2]["strokes"], 1);
  EXPECT_EQ(face_class, expected);
}

TEST(LabelServe, HandsOverTheMeshAsItWasRead) {
  const Conversation talk;
  const auto folder = talk.person.folder / "hand over";
  const Json mesh = talk.answers(Json{{"do", "mesh"}, {"folder", folder.string()}}.dump())[1];
  const Scan scan = read_scan(talk.job.scan);
  ASSERT_EQ(mesh["faces"], scan.face_count());
  EXPECT_EQ(mesh["scan_sha256"], sha256_of_file(talk.job.scan));
  EXPECT_EQ(mesh["materials"][0]["picture"], scan.materials[0].diffuse.file.string());
  const std::string bytes = read_file(mesh["file"].get<std::string>());
  const size_t p = scan.positions.size(), f = scan.face_count(), c = scan.corners.size();
  ASSERT_EQ(bytes.size(), 12 * p + 4 * (f + 1) + 12 * c + 4 * f);
  EXPECT_EQ(std::memcmp(bytes.data(), scan.positions.data(), 12 * p), 0);
  EXPECT_EQ(std::memcmp(bytes.data() + 12 * p, scan.face_begin.data(), 4 * (f + 1)), 0);
  uint32_t last = 0;
  std::memcpy(&last, bytes.data() + 12 * p + 4 * (f + 1) + 4 * (c - 1), 4);
  EXPECT_EQ(last, scan.corners.back().position);
}

TEST(LabelServe, WrongLinesAreAnsweredInWordsAndChangeNothing) {
  const Conversation talk;
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {"hello", "is not well-formed JSON"},
      {"[1,2]", "is no JSON object"},
      {"{\"do\":\"stroke\"", "is not well-formed JSON"},
      {"{}", "has no \"do\""},
      {"{\"do\":5}", "\"do\" is no text"},
      {"{\"do\":\"dance\"}", "\"dance\" is not known"},
      {"{\"do\":\"undo\"}", "no stroke to undo"},
      {"{\"do\":\"stroke\",\"class\":\"silk\",\"radius_cm\":1,\"points\":[]}", "\"silk\" is no class"},
      {"{\"do\":\"stroke\",\"class\":\"skin\",\"radius_cm\":\"1\",\"points\":[]}",
       "\"radius_cm\" is no number"},
      {"{\"do\":\"stroke\",\"class\":\"skin\",\"radius_cm\":1,\"points\":[]}", "has no point"},
      {"{\"do\":\"stroke\",\"class\":\"skin\",\"radius_cm\":1,\"points\":[[1,2]]}", "not [face, x, y, z]"},
      {"{\"do\":\"stroke\",\"class\":\"skin\",\"radius_cm\":1,\"points\":[[-1,0,0,0]]}",
       "not [face, x, y, z]"},
      {"{\"do\":\"stroke\",\"class\":\"skin\",\"radius_cm\":1,\"points\":[[9999,0,0,0]]}",
       "face 9999 does not exist"},
      {"{\"do\":\"stroke\",\"class\":\"skin\",\"radius_cm\":1,\"points\":[[0,900,0,0]]}",
       "cm away from its face 0"},
      {"{\"do\":\"save\",\"file\":\"/nowhere/at/all/s.xml\"}", "/nowhere"},
      {"{\"do\":\"\xff\"}", ""},
      // Brackets that would use up the stack of whoever copies or prints them.
      {"{\"do\":\"undo\",\"id\":" + std::string(100000, '[') + std::string(100000, ']') + "}",
       "deeper than 64"},
      {"{\"do\":\"undo\",\"id\":" + std::string(500000, '['), "deeper than 64"},
      {"{\"do\":\"save\",\"file\":\"" + std::string(5000, 'n') + "\"}", "name too long"},
      {std::string(kMaxRequest_bytes + 10, 'x'), "longer than 16 MiB"},
      {"{\"do\":\"strokes\",\"strokes\":{}}", "\"strokes\" is no list"},
      {"{\"do\":\"strokes\",\"strokes\":[1]}", "a stroke is no JSON object"},
      {"{\"do\":\"mesh\",\"folder\":\"/proc/none\"}", "/proc/none"}};
  std::string requests = "\n";
  for (const auto& [line, message] : wrong) requests += line + "\n";
  const auto answers = talk.answers(requests + "{\"do\":\"undo\"}");
  ASSERT_EQ(answers.size(), wrong.size() + 2);
  for (size_t i = 0; i < wrong.size(); ++i) {
    ASSERT_TRUE(answers[i + 1].contains("error")) << wrong[i].first;
    EXPECT_NE(answers[i + 1]["error"].get<std::string>().find(wrong[i].second), std::string::npos)
        << answers[i + 1];
    EXPECT_FALSE(answers[i + 1].contains("changed"));
  }
}

}  // namespace
}  // namespace ohb
