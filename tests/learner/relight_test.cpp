// humanmaterial relight from outside: the picture, the words of what it refuses, and that nothing stays.
#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "dataset/model/atomic_folder.h"
#include "dataset/model/image.h"
#include "test_maps_folder.h"
#include "test_program.h"
#include "tests/support/paths.h"

namespace ohb {
namespace {

namespace fs = std::filesystem;

std::string script(const TemporaryFolder& folder, const std::string& name, const std::string& body) {
  write_file_atomically(folder / name, "#!/bin/sh\n" + body + "\n");
  fs::permissions(folder / name, fs::perms::owner_all);
  return folder / name;
}

/// Exit code 2 (or another), one line on stderr with these words, no picture.
void expect_refusal(const TemporaryFolder& folder, std::vector<std::string> arguments,
                    std::initializer_list<std::string> words, int code = 2) {
  arguments.insert(arguments.begin(), "relight");
  arguments.insert(arguments.end(), {"-o", folder / "relit.png", "--spp", "1"});
  const Result result = run(folder, arguments);
  EXPECT_EQ(result.code, code) << result.error;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  EXPECT_EQ(result.error.rfind("humanmaterial: ", 0), 0u) << result.error;
  for (const std::string& part : words)
    EXPECT_NE(result.error.find(part), std::string::npos) << "\"" << part << "\" is not in: " << result.error;
  EXPECT_FALSE(fs::exists(folder / "relit.png"));
}

TEST(Relight, WritesThePictureAndSaysSo) {
  TemporaryFolder folder;
  write_ball_maps(folder / "maps", 24);
  const std::string studio = source_path("assets/environments/studio.exr");
  std::vector<std::string> command = {"relight",
                                      folder / "maps",
                                      "--environment",
                                      studio,
                                      "--rotation",
                                      "-40",
                                      "--strength",
                                      "0.5",
                                      "--point",
                                      "-50,150,200,2",
                                      "--point",
                                      "50,150,200,1",
                                      "--edit",
                                      "fabric:shiny_leather",
                                      "--edit",
                                      "hair:#803020",
                                      "--size",
                                      "48",
                                      "--spp",
                                      "2",
                                      "-o",
                                      folder / "relit.png",
                                      "--json"};
  const Result result = run(folder, command);
  ASSERT_EQ(result.code, 0) << result.error;
  EXPECT_EQ(result.error.find("Fra:"), std::string::npos) << "Blender's words are hidden: " << result.error;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_EQ(report["size_px"], (std::vector<int>{48, 48}));
  ASSERT_EQ(report["warnings"].size(), 1u) << report["warnings"];  // the maps have no hair
  EXPECT_NE(report["warnings"][0].get<std::string>().find("hair"), std::string::npos) << report["warnings"];
  ImageFileInfo info;
  const Image picture = read_image(folder / "relit.png", &info);
  EXPECT_EQ(info.bits, 16);
  EXPECT_EQ(picture.width_px, 48);
  ASSERT_EQ(picture.channels, 4);
  EXPECT_GT(picture.pixel(24, 24)[1], 0.01f);
  EXPECT_EQ(picture.pixel(24, 24)[3], 1);
  EXPECT_EQ(picture.pixel(1, 1)[3], 0) << "transparent";
}

TEST(Relight, RefusesInOneLine) {
  TemporaryFolder folder;
  write_ball_maps(folder / "maps", 16);
  const std::string maps = folder / "maps", light = "0,100,300,2";
  expect_refusal(folder, {maps}, {"there is no light", "--environment"});
  expect_refusal(folder, {folder / "none", "--point", light}, {"none", "maps.json"});
  expect_refusal(folder, {maps, "--point", "1,2"}, {"1,2"});
  expect_refusal(folder, {maps, "--point", light, "--edit", "fabric:jelly"}, {"fabric:jelly", "no preset"});
  expect_refusal(folder, {maps, "--point", light, "--edit", "nose:red"}, {"nose:red", "no class"});
  expect_refusal(folder, {maps, "--environment", folder / "none.exr"}, {"none.exr"});
  expect_refusal(folder, {maps, "--point", light, "--seed", "5000000000"}, {"--seed"});
  expect_refusal(folder, {maps, "--point", light, "--background", "pink"}, {"--background"});
}

TEST(Relight, NamesABlenderThatIsNone) {
  TemporaryFolder folder;
  const auto with = [&](const std::string& blender) {
    return std::vector<std::string>{folder / "maps", "--point", "0,100,300,2", "--blender", blender};
  };
  expect_refusal(folder, with(folder / "nowhere"), {"nowhere", "was not found", "--blender"});
  expect_refusal(folder, with(script(folder, "hello", "echo hello")), {"hello", "does not answer"});
  expect_refusal(folder, with(script(folder, "old", "echo Blender 3.3.9")), {"Blender 3.3.9", "3.4"});
}

TEST(Relight, ASignalStopsASilentBlenderAtOnce) {
  TemporaryFolder folder;
  const fs::path started = folder / "started";
  const std::string blender = script(folder, "blender",
                                     "[ $1 = --version ] && exec echo Blender 4.2.1\n"
                                     "touch '" +
                                         started.string() + "'; exec sleep 60");
  Program program(folder, {"relight", folder / "maps", "--blender", blender, "-o", folder / "relit.png"});
  for (int i = 0; i < 600 && !fs::exists(started); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const auto start = std::chrono::steady_clock::now();
  program.send(SIGTERM);
  EXPECT_EQ(program.wait().code, 75);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

TEST(Relight, ATornPictureIsNoPicture) {
  // As Blender does on a full disk: the start of the picture, and exit code 0.
  TemporaryFolder folder;
  const std::string write =
      "for a in \"$@\"; do case \"$a\" in --output=*) out=${a#*=};; --report=*) report=${a#*=};; esac; done\n"
      "echo '{\"size_px\": [16, 16]}' > \"$report\"\n";
  const auto blender = [&](const std::string& body) {
    return std::vector<std::string>{
        folder / "maps", "--point", "0,100,300,2", "--blender",
        script(folder, "blender", "[ $1 = --version ] && exec echo Blender 4.2.1\n" + write + body)};
  };
  write_png(folder / "whole.png", Image(16, 16, 4));
  write_png(folder / "small.png", Image(8, 16, 4));
  const std::string whole = folder / "whole.png", small = folder / "small.png";
  expect_refusal(folder, blender("head -c 60 " + whole + " > \"$out\""),
                 {"relit.png", "not write the picture whole"}, 75);
  expect_refusal(folder, blender("exit 0"), {"relit.png", "not write the picture whole"}, 75);
  expect_refusal(folder, blender("cp " + small + " \"$out\""), {"another size"}, 75);
  std::vector<std::string> command = blender("cp " + whole + " \"$out\"");
  command.insert(command.begin(), "relight");
  command.insert(command.end(), {"-o", folder / "relit.png", "--json"});
  EXPECT_EQ(run(folder, command).code, 0);
  EXPECT_EQ(read_file(folder / "relit.png"), read_file(folder / "whole.png"));
  EXPECT_EQ(names_in(folder.path()),
            (std::set<std::string>{"blender", "relit.png", "small.png", "stderr", "stdout", "whole.png"}));
}

TEST(Relight, NeverWritesOverItsInputsOrOtherOutputs) {
  TemporaryFolder folder;
  write_ball_maps(folder / "maps", 16);
  fs::create_directory_symlink(folder / "maps", folder / "link");
  fs::copy_file(folder / "maps" / "diffuse.png", folder / "sky.png");
  {
    AtomicFolder model(folder / "model", "model");
    write_png(model.path() / "albedo.png", Image(4, 4, 3));
    model.commit();
  }
  const auto refused = [&](const fs::path& output, const std::string& words) {
    const std::string before = read_file(output);
    const Result result =
        run(folder, {"relight", folder / "maps", "--environment", folder / "sky.png", "-o", output});
    EXPECT_EQ(result.code, 2) << result.error;
    EXPECT_NE(result.error.find(words), std::string::npos) << result.error;
    EXPECT_EQ(read_file(output), before);
  };
  refused(folder / "maps" / "diffuse.png", "read by this command");
  refused(folder / "link" / "normal.png", "read by this command");
  refused(folder / "sky.png", "read by this command");
  refused(folder / "model" / "albedo.png", "belongs to the model");
}

TEST(Relight, ExitCodesPassThrough) {
  TemporaryFolder folder;
  const auto blender = [&](const std::string& body) {
    return std::vector<std::string>{
        folder / "maps", "--point", "0,100,300,2", "--blender",
        script(folder, "blender", "[ $1 = --version ] && exec echo Blender 4.2.1\n" + body)};
  };
  expect_refusal(folder, blender("echo 'relight: a.png: the disk is full' >&2; exit 75"), {"disk is full"},
                 75);
  expect_refusal(folder, blender("printf 'chatter relight: no such thing\\n'; exit 2"), {": no such thing"});
  expect_refusal(folder, blender("kill -9 $$"), {"signal 9"}, 75);
  std::vector<std::string> command = blender("echo 'Traceback'; echo 'KeyError: 3'; exit 70");
  command.insert(command.begin(), "relight");
  command.insert(command.end(), {"-o", folder / "relit.png"});
  const Result bug = run(folder, command);
  EXPECT_EQ(bug.code, 70);
  EXPECT_NE(bug.error.find("Traceback\n"), std::string::npos) << "Blender's words are shown: " << bug.error;
  EXPECT_NE(bug.error.find("a bug: "), std::string::npos) << bug.error;
}

}  // namespace
}  // namespace ohb
