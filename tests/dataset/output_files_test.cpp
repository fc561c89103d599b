// Outputs appear whole, replace nothing but their like, and leave nothing behind when they are killed.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include "dataset/model/atomic_file.h"
#include "dataset/model/atomic_folder.h"
#include "dataset/model/image.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

namespace fs = std::filesystem;

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

/// A folder of that kind with a.txt and maps/b.txt in it.
void write_folder(const fs::path& folder, const std::string& kind, const std::string& content = "1") {
  AtomicFolder out(folder, kind);
  write_file_atomically(out.path() / "a.txt", content);
  make_folders(out.path() / "maps");
  write_file_atomically(out.path() / "maps" / "b.txt", content);
  out.commit();
}

std::string refusal(const fs::path& folder, const std::string& kind,
                    const std::vector<fs::path>& inputs = {}) {
  return input_error_of([&] { AtomicFolder out(folder, kind, inputs); });
}

/// Runs `action` in a child that is killed (SIGKILL) once it has returned.
template <typename Action>
void killed_after(const Action& action) {
  const pid_t child = ::fork();
  if (child == 0) {
    action();
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
}

TEST(AtomicFile, NothingHalfWrittenStays) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "kept.txt", "old");
  EXPECT_ANY_THROW(write_file_atomically(folder / "kept.txt", [](const fs::path& temporary) {
    write_file_atomically(temporary.string() + ".side", "x");
    fs::remove(temporary.string() + ".side");
    throw std::runtime_error("power cut");
  }));
  EXPECT_EQ(read_file(folder / "kept.txt"), "old");
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"kept.txt"});
}

TEST(AtomicFile, NeverTakesThePlaceOfADeviceOrAPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  expect_message(input_error_of([&] { write_file_atomically(folder / "pipe", "text"); }), {"pipe", "a file"});
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(AtomicFile, FollowsLinks) {
  const TemporaryFolder folder;
  make_folders(folder / "disk");
  write_file_atomically(folder / "disk" / "picture.txt", "old");
  fs::create_symlink("disk/picture.txt", folder / "link");
  write_file_atomically(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_file(folder / "disk" / "picture.txt"), "new");
}

TEST(AtomicFile, PicturesAreWrittenToTheLockedFileItself) {
  // A writer that made a file of its own of that name would leave the lock on one that is gone.
  const TemporaryFolder folder;
  struct stat before {
  }, after{};
  write_file_atomically(folder / "a.exr", [&](const fs::path& temporary) {
    ASSERT_EQ(::stat(temporary.c_str(), &before), 0);
    write_exr(folder / "b.exr", {{"rgb", {"R", "G", "B"}, ExrPart::Type::kHalf, Image(4, 4, 3)}}, {});
    fs::copy_file(folder / "b.exr", temporary, fs::copy_options::overwrite_existing);
    ASSERT_EQ(::stat(temporary.c_str(), &after), 0);
  });
  EXPECT_EQ(before.st_ino, after.st_ino);
}

TEST(AtomicFolder, ReplacesOnlyItsOwn) {
  const TemporaryFolder folder;
  write_folder(folder / "out", "model");
  {
    AtomicFolder again(folder / "out", "model");
    write_file_atomically(again.path() / "c.txt", "2");
  }
  EXPECT_TRUE(fs::exists(folder / "out" / "a.txt")) << "without commit the old one stays";
  {
    AtomicFolder again(folder / "out", "model");
    write_file_atomically(again.path() / "c.txt", "2");
    again.commit();
  }
  EXPECT_EQ(names_in(folder / "out"), (std::set<std::string>{".openhumanbrdf", "c.txt"}));
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"out"});
  fs::create_directory(folder / "mine");
  write_file_atomically(folder / "mine" / "thesis.tex", "years of work");
  expect_message(refusal(folder / "mine", "model"), {"mine", "was not written by this program"});
  fs::create_directory(folder / "empty");
  write_folder(folder / "empty", "model");
}

TEST(AtomicFolder, RefusesOtherKindsAndOldMarkers) {
  const TemporaryFolder folder;
  write_folder(folder / "out", "model");
  expect_message(refusal(folder / "out", "regions"),
                 {"out", "holds model", "regions would be", "another -o"});
  write_file_atomically(folder / "out" / ".openhumanbrdf", std::string("written by openhumanbrdf 1.0.0\n"));
  expect_message(refusal(folder / "out", "model"), {"older version", "remove it yourself"});
  EXPECT_EQ(read_file(folder / "out" / "a.txt"), "1");
}

TEST(AtomicFolder, RefusesWhatSomebodyPutThere) {
  const TemporaryFolder folder;
  write_folder(folder / "out", "model");
  const auto refused_with = [&](const std::string& name) {
    expect_message(refusal(folder / "out", "model"), {"out", "'" + name + "'", "move what you want to keep"});
    fs::remove_all(folder / "out" / name);
  };
  write_file_atomically(folder / "out" / "notes.txt", "mine");
  refused_with("notes.txt");
  write_file_atomically(folder / "out" / "maps" / ".hidden", "mine");
  refused_with("maps/.hidden");
  fs::create_directories(folder / "out" / "plans" / "later");
  refused_with("plans/");
  fs::create_symlink("/", folder / "out" / "link");
  refused_with("link");
  // Fewer files than were written are nobody's loss.
  fs::remove(folder / "out" / "a.txt");
  write_folder(folder / "out", "model", "2");
  EXPECT_EQ(read_file(folder / "out" / "a.txt"), "2");
}

TEST(AtomicFolder, LooksAgainBeforeItReplaces) {
  const TemporaryFolder folder;
  write_folder(folder / "out", "model");
  AtomicFolder again(folder / "out", "model");
  write_file_atomically(folder / "out" / "notes.txt", "written while it was at work");
  expect_message(input_error_of([&] { again.commit(); }), {"notes.txt"});
  EXPECT_TRUE(fs::exists(folder / "out" / "notes.txt"));
}

TEST(AtomicFolder, RefusesToReplaceItsInputs) {
  const TemporaryFolder folder;
  write_folder(folder / "out", "regions");
  fs::create_directory_symlink(folder / "out", folder / "same");
  for (const char* input : {"out", "out/a.txt", "same/maps/b.txt", "out/../out"})
    expect_message(refusal(folder / "out", "regions", {folder / input}),
                   {"out", input, "which this command reads"});
  expect_message(refusal(folder / "same", "regions", {folder / "out" / "a.txt"}),
                 {"which this command reads"});
  AtomicFolder fine(folder / "out", "regions", {"", folder / "nowhere", folder.path(), folder / "outside"});
  expect_message(input_error_of([&] { fine.protect({folder / "out" / "a.txt"}); }),
                 {"which this command reads"});
}

TEST(AtomicFolder, FollowsALinkAndKeepsIt) {
  const TemporaryFolder folder;
  write_folder(folder / "disk" / "model", "model");
  fs::create_directory_symlink("disk/model", folder / "link");
  write_folder(folder / "link", "model", "2");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_file(folder / "disk" / "model" / "a.txt"), "2");
  EXPECT_EQ(names_in(folder / "disk"), std::set<std::string>{"model"});
  fs::create_directory_symlink("disk/later", folder / "dangling");
  write_folder(folder / "dangling", "model", "3");
  EXPECT_EQ(read_file(folder / "disk" / "later" / "a.txt"), "3");
  write_folder((folder / "disk" / "model").string() + "/", "model", "4");
  EXPECT_EQ(read_file(folder / "link" / "a.txt"), "4");
}

TEST(AtomicFolder, ALongNameIsNoHindrance) {
  const TemporaryFolder folder;
  const std::string name(250, 'n');
  write_folder(folder / name, "model");
  write_folder(folder / name, "model", "2");
  EXPECT_EQ(read_file(folder / name / "a.txt"), "2");
  write_file_atomically(folder / (name + ".txt"), "3");
  EXPECT_EQ(read_file(folder / (name + ".txt")), "3");
}

TEST(AtomicFolder, IsAlwaysThere) {
  // Somebody who looks all the time while it is replaced finds one or the other, whole.
  const TemporaryFolder folder;
  write_folder(folder / "out", "model");
  std::atomic<bool> done{false};
  std::atomic<int> missing{0}, looks{0};
  std::thread looker([&] {
    for (; !done; ++looks)
      if (::access((folder / "out" / "a.txt").c_str(), F_OK) != 0) ++missing;
  });
  for (int i = 0; i < 100; ++i) write_folder(folder / "out", "model", std::to_string(i));
  done = true;
  looker.join();
  EXPECT_GT(looks, 1000);
  EXPECT_EQ(missing, 0);
}

TEST(ClaimedFolder, KeepsItsKind) {
  const TemporaryFolder folder;
  claim_folder(folder / "samples", "samples");
  claim_folder(folder / "samples", "samples");
  expect_message(input_error_of([&] { claim_folder(folder / "samples", "a training run"); }),
                 {"holds samples", "a training run would be"});
  expect_message(refusal(folder / "samples", "model"), {"holds samples", "model would be"});
  write_folder(folder / "model", "model");
  expect_message(input_error_of([&] { claim_folder(folder / "model", "samples"); }), {"holds model"});
}

TEST(ClaimedFolder, TakesNobodysPlace) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "mine");
  fs::create_directory(folder / "empty");
  write_file_atomically(folder / "mine/sheet.png", "mine");
  expect_message(input_error_of([&] { claim_folder(folder / "mine", "samples"); }),
                 {"holds 'sheet.png'", "not written by this program", "choose another -o"});
  EXPECT_EQ(names_in(folder / "mine"), std::set<std::string>{"sheet.png"});
  // What file managers and killed runs leave.
  write_file_atomically(folder / "empty/.DS_Store", "x");
  claim_folder(folder / "empty", "samples");
  EXPECT_EQ(read_marker(folder / "empty")->kind, "samples");
}

TEST(Leftovers, OfKilledWritersAreSwept) {
  const TemporaryFolder folder;
  killed_after([&] {
    new AtomicFolder(folder / "out", "model");
    new LockedTemporary(folder / "view_000.exr", LockedTemporary::Kind::kFile);
  });
  std::set<std::string> names = names_in(folder.path());
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names.begin()->rfind(".out.", 0), 0u);
  EXPECT_EQ(names.rbegin()->substr(names.rbegin()->size() - 8), ".tmp.exr");
  // What lives and what only looks alike stays.
  const LockedTemporary alive(folder / "alive", LockedTemporary::Kind::kFolder);
  for (const char* name : {".notes.tmp", "a.1-2.tmp", ".a.1-x.tmp", ".a.1-2.tmpx"})
    write_file_atomically(folder / name, "mine");
  write_folder(folder / "out", "model");
  names = names_in(folder.path());
  EXPECT_EQ(names, (std::set<std::string>{"out", ".notes.tmp", "a.1-2.tmp", ".a.1-x.tmp", ".a.1-2.tmpx",
                                          alive.path().filename().string()}));
}

TEST(Leftovers, AreNotJudgedByTheirProcessId) {
  // Our own id is alive, yet nobody holds the lock: the id was used again. One of a dead process is held.
  const TemporaryFolder folder;
  make_folders(folder / (".out." + std::to_string(::getpid()) + "-99999.tmp"));
  const fs::path held = folder / ".view_000.999999999-0.tmp.exr";
  { std::ofstream(held) << "x"; }
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const int handle = ::open(held.c_str(), O_RDWR);
    const char ready = ::flock(handle, LOCK_EX) == 0 ? 'y' : 'n';
    if (::write(ends[1], &ready, 1) == 1) ::pause();
    ::_exit(1);
  }
  char ready = 'n';
  ASSERT_EQ(::read(ends[0], &ready, 1), 1);
  ASSERT_EQ(ready, 'y');
  sweep_leftovers(folder.path());
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{held.filename().string()});
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  sweep_leftovers(folder.path());
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{});
}

TEST(Leftovers, AFolderThatSteppedAsideComesBack) {
  const TemporaryFolder folder;
  write_folder(folder / "fresh", "model", "new");
  write_folder(folder / "out", "model", "old");
  replace_in_two_steps(folder / "fresh", folder / "out");
  EXPECT_EQ(read_file(folder / "out" / "a.txt"), "new");
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"out"});
  // Killed between the two.
  fs::rename(folder / "out", folder / ".out.123-0.old");
  write_file_atomically(folder / "other.txt", "the next command");
  sweep_leftovers(folder.path());
  EXPECT_EQ(read_file(folder / "out" / "a.txt"), "new");
  // Killed after the second: the new one is there, the old one goes.
  fs::copy(folder / "out", folder / ".out.123-1.old", fs::copy_options::recursive);
  sweep_leftovers(folder.path());
  EXPECT_EQ(names_in(folder.path()), (std::set<std::string>{"out", "other.txt"}));
}

TEST(Hash, OfAFileIsThatOfItsBytes) {
  const TemporaryFolder folder;
  const std::string bytes(3'000'000, 'x');
  write_file_atomically(folder / "f", bytes);
  EXPECT_EQ(sha256_of_file(folder / "f"), sha256_of(bytes));
  EXPECT_EQ(sha256_of("abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-2
}

}  // namespace
}  // namespace ohb
