// SPDX-License-Identifier: Apache-2.0
// The DDS library is in the program: it refuses a domain that does not exist by its number.
#include "sessions.hpp"

#include <iostream>

int main() {
  const std::string problem = problem_of_domain(1000);
  std::cout << problem << '\n';
  return problem.find("domain 1000") != std::string::npos ? 0 : 1;
}
