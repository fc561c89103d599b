// The commands of humanmaterial, each in its own cmd_<name>.cpp.
#pragma once

#include <string>

#include "dataset/program/commands.h"

namespace ohb::learner {

using Commands = program::Commands;
using CommonOptions = program::CommonOptions;

/// --device: its value is one for device_of (learner/device.h).
void add_device_option(CLI::App& command, std::string& device);

/// Adds every command to the app.
void add_commands(CLI::App& app, Commands& commands);

/// Sets the threads of libtorch and, where `threads` is above 0, of the path tracer (TBB); called once by
/// every command before it computes.
void use_threads(int threads);

}  // namespace ohb::learner
