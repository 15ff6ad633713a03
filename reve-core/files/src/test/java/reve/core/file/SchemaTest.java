// SPDX-License-Identifier: Apache-2.0
package reve.core.file;

import static org.assertj.core.api.Assertions.assertThat;

import com.networknt.schema.InputFormat;
import com.networknt.schema.SchemaLocation;
import com.networknt.schema.SchemaRegistry;
import com.networknt.schema.SpecificationVersion;

import org.junit.jupiter.api.Test;

import tools.jackson.databind.JsonNode;
import tools.jackson.databind.json.JsonMapper;

import java.io.IOException;
import java.io.InputStream;
import java.nio.charset.StandardCharsets;

/** The schema for editors and for {@link SchemaCheck}. */
class SchemaTest {
    private static String schema() throws IOException {
        try (InputStream in = WorldFile.class.getResourceAsStream("/reve-world.schema.json")) {
            return new String(in.readAllBytes(), StandardCharsets.UTF_8);
        }
    }

    @Test
    void followsJsonSchema2020() throws IOException {
        var metaSchema =
                SchemaRegistry.withDefaultDialect(SpecificationVersion.DRAFT_2020_12)
                        .getSchema(
                                SchemaLocation.of("https://json-schema.org/draft/2020-12/schema"));
        assertThat(metaSchema.validate(schema(), InputFormat.JSON)).isEmpty();
    }

    @Test
    void everyMappingIsClosedOrSaysWhatItsValuesAre() throws IOException {
        assertClosed("", JsonMapper.shared().readTree(schema()));
    }

    @Test
    void formatVersionIsTheOneThatIsRead() throws IOException {
        assertThat(JsonMapper.shared().readTree(schema()).at("/properties/reve/const").asInt())
                .isEqualTo(WorldFile.FORMAT_VERSION);
    }

    private static void assertClosed(String at, JsonNode schema) {
        if (schema.path("type").toString().contains("object")) {
            assertThat(schema.has("additionalProperties")).as("%s is open", at).isTrue();
        }
        schema.forEachEntry(
                (key, child) -> {
                    if (child.isObject()) {
                        assertClosed(at + "/" + key, child);
                    }
                });
    }
}
