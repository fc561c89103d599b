// The ends of a program: whatever happens becomes one line on stderr and an exit code (error.h).
#pragma once

#include <functional>
#include <string>

namespace ohb::program {

/// The body of main(): catches signals, runs `body` and returns its code. What it throws, or a library's
/// thread throws with nobody to catch it, becomes "program: words" and a code: bad input 2, stopped or no
/// memory (then the words end with `memory_mend`) 75, anything else 70, "a bug". A library that calls exit()
/// because it finds no memory or no thread gives 75 too.
int run_program(const std::string& program, const char* memory_mend, const std::function<int()>& body);

}  // namespace ohb::program
