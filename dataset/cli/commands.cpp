#include "dataset/cli/commands.h"

namespace ohb {

// Each of these is in its own cmd_<name>.cpp.
void add_inspect_command(CLI::App& app, Commands& commands);
void add_label_command(CLI::App& app, Commands& commands);
void add_bake_command(CLI::App& app, Commands& commands);
void add_render_command(CLI::App& app, Commands& commands);
void add_validate_command(CLI::App& app, Commands& commands);
void add_chart_command(CLI::App& app, Commands& commands);
void add_people_command(CLI::App& app, Commands& commands);
void add_produce_command(CLI::App& app, Commands& commands);
void add_submit_command(CLI::App& app, Commands& commands);
void add_status_command(CLI::App& app, Commands& commands);
void add_verify_command(CLI::App& app, Commands& commands);
void add_environments_command(CLI::App& app, Commands& commands);
void add_export_command(CLI::App& app, Commands& commands);

void add_commands(CLI::App& app, Commands& commands) {
  add_inspect_command(app, commands);
  add_label_command(app, commands);
  add_bake_command(app, commands);
  add_render_command(app, commands);
  add_validate_command(app, commands);
  add_chart_command(app, commands);
  add_people_command(app, commands);
  add_produce_command(app, commands);
  add_submit_command(app, commands);
  add_status_command(app, commands);
  add_verify_command(app, commands);
  add_environments_command(app, commands);
  add_export_command(app, commands);
}

}  // namespace ohb
