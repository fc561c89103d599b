// Every reader under random damage. OHB_FUZZ_INPUTS: inputs in all (default 800, a short run); OHB_FUZZ_SEED:
// others than those of seed 1; OHB_FUZZ_ONLY=Reader:input repeats one. tests/fuzz.sh builds it with
// sanitizers and runs it.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "dataset/model/error.h"
#include "tests/fuzz/mutate.h"
#include "tests/fuzz/readers.h"
#include "tests/support/scan_files.h"
#include "tests/support/test_files.h"

namespace ohb {
namespace {

namespace fs = std::filesystem;

size_t number_in(const char* variable, size_t otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

uint32_t seed_of(const std::string& reader, size_t input) {
  uint32_t hash = 2166136261u + static_cast<uint32_t>(number_in("OHB_FUZZ_SEED", 1));
  for (const char c : reader) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return (hash ^ static_cast<uint32_t>(input)) * 16777619u;
}

struct Outcome {
  size_t read = 0, refused = 0;
  double slowest_s = 0;
};

void read_one(const FuzzedReader& reader, size_t input, const fs::path& folder, Outcome& outcome) {
  std::mt19937 random(seed_of(reader.name, input));
  const size_t which = random() % reader.mutated;
  for (size_t i = 0; i < reader.files.size(); ++i)
    write_bytes(folder / reader.files[i].first,
                i == which ? mutated(reader.files[i].second, random) : reader.files[i].second);
  const std::clock_t start = std::clock();  // of the processor: other work on the machine must not matter
  try {
    reader.read(folder);
    ++outcome.read;
  } catch (const InputError& error) {
    ++outcome.refused;
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << reader.name << ":" << input << ": " << error.what();
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  EXPECT_LT(seconds, 30) << reader.name << ":" << input;
  outcome.slowest_s = std::max(outcome.slowest_s, seconds);
}

/// A sanitizer ends the process: what it was reading is then in this file of the folder.
void note(const fs::path& file, const std::string& text) {
  if (std::FILE* stream = std::fopen(file.c_str(), "w")) {
    std::fputs(text.c_str(), stream);
    std::fclose(stream);
  }
}

TEST(Fuzz, EveryReaderReadsOrRefuses) {
  const TemporaryFolder scratch;
  const std::vector<FuzzedReader> readers = fuzzed_readers(scratch.path());
  const char* const only = std::getenv("OHB_FUZZ_ONLY");
  const char* const journal = std::getenv("OHB_FUZZ_JOURNAL");
  const size_t inputs = number_in("OHB_FUZZ_INPUTS", 800),
               each = (inputs + readers.size() - 1) / readers.size();
  size_t total = 0;
  for (const FuzzedReader& reader : readers) {
    Outcome outcome;
    for (size_t input = 0; input < each; ++input) {
      const std::string name = reader.name + ":" + std::to_string(input);
      if (only && name != only && reader.name != only) continue;
      if (journal) note(journal, name + "\n");
      const TemporaryFolder folder;
      read_one(reader, input, folder.path(), outcome);
      ++total;
    }
    if (outcome.read + outcome.refused > 0)
      std::printf("%-16s %5zu read, %5zu refused, slowest %.2f s\n", reader.name.c_str(), outcome.read,
                  outcome.refused, outcome.slowest_s);
    if (!only && each >= 150) {
      EXPECT_GT(outcome.read, 0u) << reader.name << ": all refused, its inside is not reached";
    }
    std::fflush(stdout);
  }
  std::printf("%zu inputs\n", total);
}

/// Without damage each is read, so that what is refused is refused for its damage.
TEST(Fuzz, ValidInputIsRead) {
  const TemporaryFolder scratch;
  for (const FuzzedReader& reader : fuzzed_readers(scratch.path())) {
    const TemporaryFolder folder;
    for (const auto& [name, bytes] : reader.files) write_bytes(folder / name, bytes);
    EXPECT_NO_THROW(reader.read(folder.path())) << reader.name;
  }
}

}  // namespace
}  // namespace ohb
