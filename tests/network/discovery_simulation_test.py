#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The simulation of discovery, compared with its rules in closed form and with real networks.

  discovery_simulation_test.py MEASURED     lines of discovery_traffic.py
"""
import copy
import pathlib
import sys
import unittest

import discovery_simulation as simulation

MEASURED = pathlib.Path(sys.argv.pop(1))


class Discovery(unittest.TestCase):
    def test_in_rest_each_announces_to_all_and_to_each(self):
        for benches in (1, 2, 7, 20):
            rest = simulation.experiment(benches, benches)["sent_a_second_in_rest"]
            # 10 announcements per second on each of two interfaces, and one to each other bench.
            self.assertEqual(rest["multicast"], 10 * 2 * benches)
            self.assertEqual(rest["unicast"], 10 * benches * (benches - 1))
            # 20 states per second: two to the own reader, one to each other bench.
            self.assertEqual(rest["data"], 20 * benches * (benches + 1))

    def test_a_participant_of_the_same_host_gets_announcements_at_both_addresses(self):
        rest = simulation.experiment(6, 3)["sent_a_second_in_rest"]
        # Each of 6 benches has one neighbour, with two addresses, and four others.
        self.assertEqual(rest["unicast"], 10 * 6 * (2 + 4))
        self.assertEqual(rest["data"], 20 * 6 * (2 + 2 + 4))

    def test_a_pair_exchanges_its_endpoints_once(self):
        rules = simulation.Rules()
        once = simulation.experiment(2, 2)["sent_until_rest"]
        # Both start at 0 and know each other once the first one announces. Announcements until 6 s:
        # at 0, 0.05, ... 0.45 s and then every 0.1 s, 10 + 55 in total; all except the very first
        # are also sent to the other bench.
        self.assertEqual(once["multicast"], 2 * 2 * 65)
        self.assertEqual(once["unicast"], 2 * 65 - 1 + 2 * (1 + rules.endpoint_datagrams))

    def test_probes_ignore_each_other(self):
        sut = simulation.Simulation(3, 3, with_probes=True)
        sut.run_until(1.0)
        self.assertTrue(sut.is_complete())
        self.assertEqual([len(one.known) for one in sut.participants], [5, 5, 5, 3, 3, 3])

    def test_participants_above_the_limit_do_not_all_find_each_other(self):
        rules = simulation.Rules(most_known=8)
        self.assertTrue(simulation.experiment(9, 9, rules=rules)["is_complete"])
        self.assertFalse(simulation.experiment(10, 10, rules=rules)["is_complete"])

    def test_each_run_is_the_same(self):
        self.assertEqual(simulation.experiment(30, 4, 1.0, 7.0, "process"),
                         simulation.experiment(30, 4, 1.0, 7.0, "process"))

    def test_real_networks_send_the_simulated_counts(self):
        lines = simulation.of_benches_alone(MEASURED.read_text(encoding="utf-8"))
        self.assertGreaterEqual(len(lines), 8)
        self.assertEqual({line["wire"] for line in lines}, {"thread", "process"})
        self.assertEqual(simulation.check(lines), [])

    def test_the_comparison_finds_a_network_that_sends_1_5_times_as_much(self):
        lines = simulation.of_benches_alone(MEASURED.read_text(encoding="utf-8"))
        line = [line for line in lines if line["wire"] == "thread"][-1]
        for part, kind, _ in simulation.TOLERANCES:
            other = copy.deepcopy(line)
            other[part][kind] *= 1.5
            self.assertTrue(simulation.check([other]), f"{part} {kind}")


if __name__ == "__main__":
    unittest.main()
