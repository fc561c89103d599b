// What both programs share: ranges of options, names that were probably meant, help of 80 columns.
#include <gtest/gtest.h>

#include "dataset/program/command_line.h"
#include "dataset/program/help.h"
#include "dataset/program/option_checks.h"

namespace ohb {
using namespace program;
namespace {

TEST(OptionChecks, RefuseAllThatIsNoFiniteNumberInTheRange) {
  const CLI::Validator number = number_within(0.5, 100), whole = whole_within(2, 100);
  for (std::string good : {"0.5", "100", "7.25", "1e1"}) EXPECT_EQ(number(good), "") << good;
  for (std::string good : {"2", "100", "010"}) EXPECT_EQ(whole(good), "") << good;
  for (std::string bad : {"", " ", "nan", "-nan", "inf", "-inf", "infinity", "1e999", "-1e999", "1e-999",
                          "0.499", "101", "5x", "x", "5 ", "0x10", "--", "1,5"})
    EXPECT_NE(number(bad).find("from 0.5 to 100"), std::string::npos) << bad;
  for (std::string bad :
       {"", "nan", "1", "101", "-3", "2.5", "1e1", "99999999999999999999999", "0x10", "2147483648"})
    EXPECT_NE(whole(bad).find("from 2 to 100"), std::string::npos) << bad;
}

TEST(CommandLine, NamesWhatWasProbablyMeant) {
  const std::vector<std::string> commands = {"inspect", "label", "bake", "render", "validate", "chart"};
  const auto meant = [&](const char* word) { return nearest_name(word, commands).value_or(""); };
  EXPECT_EQ(meant("rendre"), "render");
  EXPECT_EQ(meant("lable"), "label");
  EXPECT_EQ(meant("validat"), "validate");
  EXPECT_EQ(meant("bkae"), "bake");
  EXPECT_EQ(meant("insp"), "inspect");
  EXPECT_EQ(meant("cook"), "");
  EXPECT_EQ(meant(""), "");
  EXPECT_EQ(meant(std::string(100000, 'r').c_str()), "");
  EXPECT_EQ(nearest_name("--enviroment", {"--environment", "--view", "--help"}), "--environment");
}

TEST(Help, WrapsAndCanBePasted) {
  EXPECT_EQ(wrapped("one two three", 8), (std::vector<std::string>{"one two", "three"}));
  EXPECT_EQ(wrapped("one\ntwo", 80), (std::vector<std::string>{"one", "two"}));
  const std::string footer = help_footer(
      {"program command --environment studio.exr --environment sunset.exr --view 3/8 --size 512 -o out"},
      "A note.");
  EXPECT_EQ(footer,
            "Examples:\n"
            "  program command --environment studio.exr --environment sunset.exr --view 3/8 \\\n"
            "      --size 512 -o out\n"
            "A note.");
}

}  // namespace
}  // namespace ohb
