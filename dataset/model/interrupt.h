// SIGINT and SIGTERM become a TryAgainError at the next safe place, so that nothing half-written stays.
#pragma once

namespace ohb {

/// Installs the handlers; called once by a program's main().
void catch_interrupts();

/// Throws TryAgainError if a signal has arrived. Cheap; called from any thread.
void throw_if_interrupted();

}  // namespace ohb
