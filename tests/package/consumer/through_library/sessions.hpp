// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

/// @return why no session can be opened on a DDS domain; empty if one can.
std::string problem_of_domain(unsigned domain);
