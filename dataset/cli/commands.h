// The commands of openhumanbrdf, each in its own cmd_<name>.cpp.
#pragma once

#include "dataset/program/commands.h"

namespace ohb {

using Commands = program::Commands;
using CommonOptions = program::CommonOptions;

/// Adds every command to the app.
void add_commands(CLI::App& app, Commands& commands);

}  // namespace ohb
