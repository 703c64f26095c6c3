// SPDX-License-Identifier: Apache-2.0
// Builds the precompiled header of the tests; has no other content.
