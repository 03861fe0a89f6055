#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace afptraj::step {

struct IsolationLimits {
  double timeout_s = 120;
  std::uint64_t memory_bytes = std::uint64_t{4} << 30;
  std::function<bool()> stop;  ///< see StepReadOptions::stop
};

/// Runs `work` in a forked child with limits on memory, CPU time, stack, files and core dumps, its
/// stdout and stderr closed off, and returns the bytes that it returns. An afptraj::Error thrown
/// in the child is thrown again here.
///
/// Throws Error(resource_limit, where) when the child dies by a signal, runs out of memory or
/// time. `diagnose` is asked for a reason to add to the message, and may return "".
///
/// The memory limit is not set under AddressSanitizer, which reserves terabytes of addresses.
std::string run_isolated(const std::string& where, const IsolationLimits& limits,
                         const std::function<std::string()>& work,
                         const std::function<std::string()>& diagnose = {});

}  // namespace afptraj::step
