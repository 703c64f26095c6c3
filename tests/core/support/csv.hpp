// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

namespace vdrive::test {

/// One line of a CSV file: cells by column name.
using CsvRow = std::map<std::string, std::string>;

/// Reads a CSV file with a header line; cells may be quoted.
/// @throws std::runtime_error if the file cannot be read or a line has a different number of cells.
std::vector<CsvRow> read_csv(const std::string& path);

}  // namespace vdrive::test
