// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import java.util.ArrayList;
import java.util.Arrays;
import java.util.List;
import java.util.regex.Pattern;

/**
 * Reader of a CSV file of numbers. The first line contains names, and the other lines contain
 * numbers. A `#` begins a comment line.
 */
final class CsvTable {
    /** Maximum number of columns of one file. */
    private static final int MAX_COLUMNS = 256;

    private static final Pattern NAME = Pattern.compile("[A-Za-z][A-Za-z0-9_.]*");

    private final Problems problems;
    private final List<String> names = new ArrayList<>();
    private double[] numbers = new double[1024];
    private int count;

    private CsvTable(Problems problems) {
        this.problems = problems;
    }

    /**
     * Reads a file as repetitions of an item, one for each line of numbers. The formulas of the
     * item may use each column as a variable. They may also use {@code i}, the number of the line
     * from 0, unless a column has this name.
     *
     * @throws WorldFileException at the first wrong line
     */
    static Repetition read(SourceFiles.Source file, SourceFiles files, Problems problems)
            throws WorldFileException {
        var table = new CsvTable(problems.of(file.name()));
        String text = files.read(file, table.problems);
        int lineNumber = 0;
        for (String line : (Iterable<String>) text.lines()::iterator) {
            lineNumber++;
            if (line.isBlank() || line.startsWith("#")) {
                continue;
            }
            if (table.names.isEmpty()) {
                table.header(line, lineNumber);
            } else {
                table.row(line, lineNumber);
            }
        }
        return table.repetition();
    }

    private void header(String line, int lineNumber) throws WorldFileException {
        int column = 1;
        for (String cell : line.split(",", -1)) {
            String name = cell.strip();
            if (!NAME.matcher(name).matches() || Formula.isTaken(name) || names.contains(name)) {
                throw problems.fatal(
                        lineNumber,
                        column,
                        "`"
                                + Node.shorten(name)
                                + "` cannot be the name of a column: expected a letter, then"
                                + " letters, digits, _ or ., neither given twice nor a function or"
                                + " constant of formulas");
            }
            if (names.size() == MAX_COLUMNS) {
                throw problems.fatal(lineNumber, column, "more than " + MAX_COLUMNS + " columns");
            }
            names.add(name);
            column += cell.length() + 1;
        }
    }

    private void row(String line, int lineNumber) throws WorldFileException {
        int begin = 0;
        for (int column = 0; column < names.size(); column++) {
            int end = line.indexOf(',', begin);
            boolean last = column == names.size() - 1;
            if (last != end < 0) {
                throw problems.fatal(
                        lineNumber,
                        begin + 1,
                        "found "
                                + line.split(",", -1).length
                                + " numbers, expected "
                                + names.size()
                                + ", one for each name in the first line");
            }
            add(
                    line.substring(begin, last ? line.length() : end).strip(),
                    names.get(column),
                    lineNumber,
                    begin + 1);
            begin = end + 1;
        }
    }

    private void add(String cell, String name, int lineNumber, int column)
            throws WorldFileException {
        double number;
        try {
            number = Double.parseDouble(cell);
        } catch (NumberFormatException notANumber) {
            number = Double.NaN;
        }
        if (!Double.isFinite(number)) {
            throw problems.fatal(
                    lineNumber,
                    column,
                    name + ": found `" + Node.shorten(cell) + "`, expected a finite number");
        }
        if (count == numbers.length) {
            numbers = Arrays.copyOf(numbers, 2 * count);
        }
        numbers[count++] = number;
    }

    private Repetition repetition() throws WorldFileException {
        if (names.isEmpty()) {
            throw problems.fatal(1, 1, "the file is empty; its first line names the columns");
        }
        int columns = names.size();
        boolean index = !names.contains("i");
        List<String> variables = new ArrayList<>(names);
        if (index) {
            variables.add("i");
        }
        return new Repetition(
                variables,
                count / columns,
                number -> {
                    double[] values =
                            Arrays.copyOfRange(
                                    numbers,
                                    (int) number * columns,
                                    (int) number * columns + variables.size());
                    if (index) {
                        values[columns] = number;
                    }
                    return values;
                });
    }
}
