package reve.core.agent;

import tools.jackson.core.JsonGenerator;

/** Writes JSON. */
record JsonWriter(JsonGenerator json) implements MessageWriter {

    @Override
    public void beginMap(int fields) {
        json.writeStartObject();
    }

    @Override
    public void endMap() {
        json.writeEndObject();
    }

    @Override
    public void beginList(int values) {
        json.writeStartArray();
    }

    @Override
    public void endList() {
        json.writeEndArray();
    }

    @Override
    public void key(String name) {
        json.writeName(name);
    }

    @Override
    public void text(String text) {
        json.writeString(text);
    }

    @Override
    public void truth(boolean truth) {
        json.writeBoolean(truth);
    }

    @Override
    public void integer(long number) {
        json.writeNumber(number);
    }

    @Override
    public void number(double number) {
        json.writeNumber(number);
    }

    @Override
    public void fragment(Fragment fragment) {
        json.writeRawValue(fragment.json());
    }

    @Override
    public void numbers(double[] numbers, int first, int count) {
        json.writeArray(numbers, first, count);
    }
}
