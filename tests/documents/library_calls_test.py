#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""library_calls.py finds each kind of mistake."""
import pathlib
import tempfile
import unittest

import library_calls

ROWS = {"DataWriter::write", "SenderResource::send", "DataReaderListener::on_data_available"}


def findings(rows=frozenset(ROWS), imported=("DataWriter::write",), called=("write", "send"),
             callbacks=("on_data_available",)):
    return library_calls.problems(set(rows), set(imported), set(called), set(callbacks))


class LibraryCalls(unittest.TestCase):
    def test_complete_tables_pass(self):
        self.assertEqual(findings(), [])

    def test_an_imported_function_without_a_row_is_found(self):
        name = "DomainParticipant::get_participant_names"
        self.assertEqual(findings(imported=("DataWriter::write", name)),
                         [f"{name} is called and has no row"])

    def test_a_virtual_function_without_a_row_is_found(self):
        self.assertEqual(findings(called=("write", "send", "dispose")),
                         ["dispose() is called through a pointer and has no row"])

    def test_a_callback_without_a_row_is_found(self):
        self.assertEqual(findings(callbacks=("on_data_available", "on_liveliness_lost")),
                         ["on_liveliness_lost() is a callback and has no row"])

    def test_a_row_without_a_call_is_found(self):
        self.assertEqual(findings(rows=ROWS | {"DataReader::read"}),
                         ["DataReader::read has a row and is not called"])

    def test_symbols_lose_namespaces_and_arguments(self):
        for symbol, name in (
                ("eprosima::fastdds::dds::DataWriter::write(void*)", "DataWriter::write"),
                ("eprosima::fastdds::dds::DomainParticipant::get_participant_names[abi:cxx11]() const",
                 "DomainParticipant::get_participant_names"),
                ("eprosima::fastdds::rtps::Deleter::operator()(eprosima::fastdds::rtps::Resource*)",
                 "Deleter::operator()"),
                ("MD5::init()", "MD5::init")):
            self.assertEqual(library_calls.short_name(symbol), name)

    def test_calls_and_callbacks_are_read_from_sources(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "writer.hpp"
            file.write_text("bool a() { return writer_->dispose(data); }  // writer_->gone()\n"
                            "void on_data_available(\n    Reader* reader) override;\n", encoding="utf-8")
            self.assertEqual(library_calls.calls_through_pointers(folder), {"dispose"})
            self.assertEqual(library_calls.callbacks_in(folder), {"on_data_available"})


if __name__ == "__main__":
    unittest.main()
