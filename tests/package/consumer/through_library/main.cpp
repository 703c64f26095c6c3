// SPDX-License-Identifier: Apache-2.0
// The program contains the DDS library if a domain that does not exist is refused by its number.
#include "sessions.hpp"

#include <iostream>

int main() {
  const std::string problem = problem_of_domain(1000);
  std::cout << problem << '\n';
  return problem.find("domain 1000") != std::string::npos ? 0 : 1;
}
