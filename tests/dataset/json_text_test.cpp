// JSON within limits, and that nothing goes around them.
#include "dataset/model/json_text.h"

#include <gtest/gtest.h>

#include <chrono>
#include <regex>

#include "dataset/model/atomic_file.h"
#include "dataset/model/xml_document.h"
#include "tests/support/paths.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

namespace fs = std::filesystem;

std::string nested(int depth) {
  return std::string(static_cast<size_t>(depth), '[') + std::string(static_cast<size_t>(depth), ']');
}

TEST(JsonText, ReadsWhatIsWithinLimits) {
  EXPECT_EQ(parse_json("{\"a\": [1, 2.5, \"x\"]}", "f")["a"][1], 2.5);
  EXPECT_EQ(parse_json<nlohmann::ordered_json>("{\"b\":1,\"a\":2}", "f").dump(), "{\"b\":1,\"a\":2}");
  EXPECT_NO_THROW(parse_json(nested(64), "f"));
  EXPECT_NO_THROW(parse_json("[1,2,3]", "f", {4, 4}));
}

TEST(JsonText, RefusesInWords) {
  const auto refuse = [](const std::string& text, std::initializer_list<std::string> words,
                         JsonLimits limits = {}) {
    expect_message(input_error_of([&] { parse_json(text, "scan.json", limits); }), words);
  };
  refuse("{\n\"a\": }", {"scan.json: line 2: is not well-formed JSON", "byte 8"});
  refuse("", {"scan.json: line 1"});
  refuse("{} x", {"well-formed"});
  refuse("[1e999]", {"number", "too large"});
  refuse(std::string("\"\xff\""), {"well-formed"});
  refuse(nested(65), {"scan.json", "deeper than 64 levels"});
  refuse("[1,2,3]", {"more than 3 values"}, {4, 3});
  // A million brackets, closed or not: no stack is used up.
  refuse(nested(1000000), {"deeper than 64"});
  refuse(std::string(1000000, '['), {"deeper than 64"});
  std::string objects;
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
  refuse(objects, {"deeper than 64"});
}

/// Of 200,000 objects side by side each is met once: with a look at all before it this takes minutes.
TEST(JsonText, TimeGrowsWithTheTextAlone) {
  std::string list = "[{}", object = "{\"0\":{}";
  for (int i = 1; i < 200000; ++i) {
    list += ",{}";
    object += ",\"" + std::to_string(i) + "\":{}";
  }
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(parse_json(list + "]", "f").size(), 200000u);
  EXPECT_EQ(parse_json(object + "}", "f").size(), 200000u);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

TEST(JsonText, WritesWhateverBytesANameHas) {
  const nlohmann::json json = {{"file", std::string("a\xff\xfe.obj")}};
  EXPECT_EQ(json_text(json), "{\"file\":\"a\xEF\xBF\xBD\xEF\xBF\xBD.obj\"}");
  EXPECT_EQ(json_text(nlohmann::json{{"a", 1}}, 2), "{\n  \"a\": 1\n}");
}

TEST(JsonText, NothingGoesAroundIt) {
  // Tests may read what they wrote themselves.
  const std::regex direct("json::parse\\(|Json::parse\\(|\\.dump\\(|json::accept\\(|sax_parse\\(|>> *json");
  for (const char* folder : {"bake", "dataset", "learner", "renderer"})
    for (const auto& entry : fs::recursive_directory_iterator(source_path(folder))) {
      const std::string name = entry.path().filename().string();
      if (!entry.is_regular_file() || name == "json_text.cpp" || name == "json_text.h") continue;
      if (entry.path().extension() != ".cpp" && entry.path().extension() != ".h") continue;
      EXPECT_FALSE(std::regex_search(read_file(entry.path()), direct))
          << entry.path() << " reads or writes JSON without dataset/model/json_text.h";
    }
}

TEST(XmlText, IsXmlWhateverBytesANameHas) {
  pugi::xml_document document;
  const std::string name = "Fran\xe7ois \x01\t<&> \xc3\xbc \xff";
  document.append_child("model").append_attribute("name") = name.c_str();
  const std::string text = xml_text(document);
  EXPECT_NE(text.find("Fran\xc3\xa7ois \xef\xbf\xbd&#09;&lt;&amp;> \xc3\xbc \xc3\xbf"), std::string::npos)
      << text;
  const TemporaryFolder folder;
  write_file_atomically(folder / "model.xml", text);
  const XmlDocument again(folder / "model.xml", "model");
  EXPECT_EQ(again.text(again.root(), "name"), "Fran\xc3\xa7ois \xef\xbf\xbd\t<&> \xc3\xbc \xc3\xbf");
}

TEST(XmlDocument, RefusesDeepNesting) {
  const TemporaryFolder folder;
  std::string text = "<rules>";
  for (int i = 0; i < 200000; ++i) text += "<a>";
  for (int i = 0; i < 200000; ++i) text += "</a>";
  write_file_atomically(folder / "rules.xml", text + "</rules>");
  expect_message(input_error_of([&] { XmlDocument(folder / "rules.xml", "rules"); }),
                 {"rules.xml: line 1", "deeper than 64"});
  write_file_atomically(folder / "flat.xml", "<rules><a><b/></a>\n<a/><c><d/><e/></c></rules>");
  EXPECT_NO_THROW(XmlDocument(folder / "flat.xml", "rules"));
}

}  // namespace
}  // namespace ohb
