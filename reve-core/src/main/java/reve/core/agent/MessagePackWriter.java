package reve.core.agent;

import java.io.IOException;
import java.io.UncheckedIOException;
import org.msgpack.core.MessagePacker;

/** Writes MessagePack to memory, where nothing goes wrong. */
record MessagePackWriter(MessagePacker packer) implements MessageWriter {

    private interface Writing {
        void write() throws IOException;
    }

    private static void write(Writing writing) {
        try {
            writing.write();
        } catch (IOException e) {
            throw new UncheckedIOException(e);
        }
    }

    @Override
    public void beginMap(int fields) {
        write(() -> packer.packMapHeader(fields));
    }

    @Override
    public void endMap() {
        // Its header says how long it is.
    }

    @Override
    public void beginList(int values) {
        write(() -> packer.packArrayHeader(values));
    }

    @Override
    public void endList() {
        // Its header says how long it is.
    }

    @Override
    public void key(String name) {
        text(name);
    }

    @Override
    public void text(String text) {
        write(() -> packer.packString(text));
    }

    @Override
    public void truth(boolean truth) {
        write(() -> packer.packBoolean(truth));
    }

    @Override
    public void integer(long number) {
        write(() -> packer.packLong(number));
    }

    @Override
    public void number(double number) {
        write(() -> packer.packDouble(number));
    }

    @Override
    public void fragment(Fragment fragment) {
        write(() -> packer.writePayload(fragment.packed()));
    }
}
