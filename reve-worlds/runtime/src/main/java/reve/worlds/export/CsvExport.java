// SPDX-License-Identifier: Apache-2.0
package reve.worlds.export;

import reve.core.disk.WholeFile;
import reve.core.world.ColumnView;
import reve.core.world.ItemId;
import reve.core.world.PropertyDescriptor;
import reve.core.world.TableSnapshot;
import reve.core.world.WorldSnapshot;

import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.OutputStreamWriter;
import java.io.Writer;
import java.nio.charset.StandardCharsets;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.Collection;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Map;
import java.util.stream.Collectors;

/**
 * Tables in CSV (RFC 4180). Each table {@code KIND.csv} has one row for each item in each frame.
 * The table {@code frame-events.csv} contains the events. Numbers have all digits. The header names
 * the unit of each column.
 */
public final class CsvExport implements Export {
    /** Text with which the header of each table begins. */
    public static final String MARK = "frame,time [s],";

    /** Name of the table of events. No kind of items can have this name. */
    private static final String EVENTS = "frame-events";

    private static final JsonMapper JSON = new JsonMapper();

    private final Map<String, Table> tables = new LinkedHashMap<>();

    /** A table that is being written. */
    private static final class Table {
        private final WholeFile file;
        private final Writer out;
        private boolean begun;

        Table(Path folder, String name) throws IOException {
            file = new WholeFile(CsvExport.file(folder, name));
            out = new OutputStreamWriter(file.out(), StandardCharsets.UTF_8);
        }

        /** Writes the header before the first row. */
        void head(String header) throws IOException {
            if (!begun) {
                begun = true;
                out.append(MARK).append(header).append('\n');
            }
        }

        void begin(WorldSnapshot snapshot) throws IOException {
            out.append(Long.toString(snapshot.frame()))
                    .append(',')
                    .append(Double.toString(snapshot.timeSeconds()));
        }
    }

    /**
     * Creates the tables.
     *
     * @param folder an existing folder
     * @param kinds the kinds of items that get a table, in order
     * @throws IOException if a file cannot be created
     */
    public CsvExport(Path folder, Collection<String> kinds) throws IOException {
        try {
            for (String kind : kinds) {
                tables.put(kind, new Table(folder, kind));
            }
            tables.put(EVENTS, new Table(folder, EVENTS));
        } catch (IOException e) {
            close();
            throw e;
        }
    }

    /** Returns the names of the files that an export of these kinds writes. */
    public static List<Path> files(Path folder, Collection<String> kinds) {
        List<Path> files = new ArrayList<>();
        kinds.forEach(kind -> files.add(file(folder, kind)));
        files.add(file(folder, EVENTS));
        return files;
    }

    private static Path file(Path folder, String name) {
        return folder.resolve(name + ".csv");
    }

    private static String header(TableSnapshot table) {
        List<String> names = new ArrayList<>(List.of("id", "item"));
        for (ColumnView column : table.columns()) {
            PropertyDescriptor property = column.descriptor();
            for (String component : Properties.components(property)) {
                String name = property.name() + (component.isEmpty() ? "" : "." + component);
                names.add(
                        Properties.isText(property)
                                ? name
                                : name + " [" + property.unit().symbol() + "]");
            }
        }
        return names.stream().map(CsvExport::cell).collect(Collectors.joining(","));
    }

    @Override
    public void add(ExportedFrame frame) throws IOException {
        WorldSnapshot snapshot = frame.snapshot();
        for (TableSnapshot table : snapshot.tables()) {
            Table written = tables.get(table.kind());
            if (written != null) {
                written.head(header(table));
                add(written, table, snapshot);
            }
        }
        Table events = tables.get(EVENTS);
        events.head("type,fields");
        for (ExportedFrame.Event event : frame.events()) {
            events.begin(snapshot);
            events.out
                    .append(',')
                    .append(cell(event.type()))
                    .append(',')
                    .append(cell(JSON.writeValueAsString(event.fields())))
                    .append('\n');
        }
    }

    private static void add(Table written, TableSnapshot table, WorldSnapshot snapshot)
            throws IOException {
        Writer out = written.out;
        List<? extends ColumnView> columns = table.columns();
        for (int row = 0; row < table.rowCount(); row++) {
            ItemId id = table.idAt(row);
            written.begin(snapshot);
            out.append(',')
                    .append(Long.toString(id.value()))
                    .append(',')
                    .append(cell(snapshot.symbols().get(id).name()));
            for (ColumnView column : columns) {
                boolean isText = Properties.isText(column.descriptor());
                for (int i = 0; i < column.components(); i++) {
                    out.append(',')
                            .append(
                                    isText
                                            ? cell(Properties.text(column, row, i, snapshot))
                                            : Properties.number(column, row, i));
                }
            }
            out.append('\n');
        }
    }

    private static String cell(String text) {
        boolean quoted = text.chars().anyMatch(c -> c == ',' || c == '"' || c == '\n' || c == '\r');
        return quoted ? '"' + text.replace("\"", "\"\"") + '"' : text;
    }

    @Override
    public void finish() throws IOException {
        for (Table table : tables.values()) {
            table.out.flush();
        }
        for (Table table : tables.values()) {
            table.file.finish();
        }
    }

    @Override
    public void close() throws IOException {
        for (Table table : tables.values()) {
            table.file.close();
        }
    }
}
