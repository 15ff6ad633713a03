package reve.worlds.journal;

import java.io.IOException;

/** Where a journal is kept. One thread. */
public interface JournalSink extends AutoCloseable {
    /**
     * Adds a record behind all others. When it returns, the record outlives the end of this
     * process.
     *
     * @throws IOException naming the file, if that failed; nothing of the record counts then
     */
    void write(JournalRecord record) throws IOException;

    @Override
    void close() throws IOException;
}
