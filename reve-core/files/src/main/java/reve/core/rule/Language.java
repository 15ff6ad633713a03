// SPDX-License-Identifier: Apache-2.0
package reve.core.rule;

import com.google.common.collect.ImmutableCollection;
import com.google.common.collect.ImmutableList;
import com.google.common.collect.ImmutableSet;

import dev.cel.checker.CelStandardDeclarations;
import dev.cel.checker.CelStandardDeclarations.StandardFunction;
import dev.cel.common.CelAbstractSyntaxTree;
import dev.cel.common.CelIssue;
import dev.cel.common.CelOptions;
import dev.cel.common.CelValidationException;
import dev.cel.common.CelValidationResult;
import dev.cel.common.types.CelType;
import dev.cel.common.types.CelTypeProvider;
import dev.cel.common.types.ListType;
import dev.cel.common.types.MapType;
import dev.cel.common.types.SimpleType;
import dev.cel.common.types.StructType;
import dev.cel.compiler.CelCompiler;
import dev.cel.compiler.CelCompilerBuilder;
import dev.cel.compiler.CelCompilerFactory;
import dev.cel.extensions.CelExtensions;
import dev.cel.parser.CelStandardMacro;
import dev.cel.runtime.CelEvaluationException;
import dev.cel.runtime.CelRuntime;
import dev.cel.runtime.CelRuntimeFactory;

import reve.core.unit.Unit;
import reve.core.world.Parameter;
import reve.core.world.SymbolType;

import java.util.HashMap;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.Objects;
import java.util.Optional;
import java.util.Set;
import java.util.TreeSet;
import java.util.regex.Matcher;
import java.util.regex.Pattern;

/**
 * The compiler of CEL expressions (cel.dev) with the names of one {@link Scope}. It does not
 * support the CEL types for time and bytes.
 */
final class Language {
    /** Maximum length of an expression [characters]. */
    static final int MAX_LENGTH = 1000;

    /** Maximum number of operators, names and constants in one expression. */
    static final int MAX_PARTS = 250;

    /**
     * Maximum number of iterations of macros such as {@code map} and {@code all} in one evaluation.
     */
    static final int MAX_ROUNDS = 1000;

    private static final CelOptions OPTIONS =
            CelOptions.current()
                    .enableHeterogeneousNumericComparisons(true)
                    .maxExpressionCodePointSize(MAX_LENGTH)
                    .maxParseExpressionNodeCount(MAX_PARTS)
                    .maxParseRecursionDepth(MAX_PARTS)
                    .comprehensionMaxIterations(MAX_ROUNDS)
                    .build();
    private static final Set<StandardFunction> LEFT_OUT =
            Set.of(
                    StandardFunction.TIMESTAMP,
                    StandardFunction.DURATION,
                    StandardFunction.BYTES,
                    StandardFunction.TYPE);
    private static final CelStandardDeclarations STANDARD =
            CelStandardDeclarations.newBuilder().excludeFunctions(LEFT_OUT).build();
    private static final CelRuntime RUNTIME =
            CelRuntimeFactory.standardCelRuntimeBuilder()
                    .setOptions(OPTIONS)
                    .addLibraries(CelExtensions.math())
                    .addFunctionBindings(Functions.bindings())
                    .build();
    private static final ListType NUMBERS = ListType.create(SimpleType.DOUBLE);
    private static final Pattern UNDEFINED = Pattern.compile("undefined field '(.*)'");
    private static final Pattern UNDECLARED =
            Pattern.compile("undeclared reference to '(.*)' \\(in container ''\\)");
    private static final Pattern INPUT =
            Pattern.compile(
                    "(?:mismatched|extraneous) input '(.*?)' expecting.*"
                            + "|token recognition error at: '(.*)'");

    /**
     * Message of the CEL library for {@code has(semantic.note)} if the symbol {@code note} is
     * declared. This message is replaced by a clearer one.
     */
    private static final String NO_FIELD = "expression does not select a field";

    private static final Pattern NO_OVERLOAD =
            Pattern.compile(
                    "found no matching overload for '(.*)' applied to '(.*)'( \\(candidates.*)?");

    private final Scope scope;
    private final CelCompiler compiler;
    private final Set<String> names = new TreeSet<>();
    private final Map<String, StructType> structs = new LinkedHashMap<>();

    /** Number of components by name, for example 3 for {@code physics.velocity}. */
    private final Map<String, Integer> components = new HashMap<>();

    private String fieldsOfLastStruct = "";

    Language(Scope scope) {
        this.scope = scope;
        CelCompilerBuilder builder =
                CelCompilerFactory.standardCelCompilerBuilder()
                        .setOptions(OPTIONS)
                        .setStandardEnvironmentEnabled(false)
                        .setStandardDeclarations(STANDARD)
                        .setStandardMacros(CelStandardMacro.STANDARD_MACROS)
                        .addLibraries(CelExtensions.math())
                        .addFunctionDeclarations(Functions.declarations());
        Map<String, CelType> own = aspects("", scope.own());
        own.put(KindNames.SELF, struct(KindNames.SELF, names()));
        CelType body = struct("body", body(scope.other()));
        if (scope.withActor()) {
            own.put(Scope.ACTOR, body);
        }
        for (Parameter parameter : scope.parameters().values()) {
            own.put(parameter.name(), type(parameter, body));
        }
        names.addAll(own.keySet());
        scope.own()
                .symbols()
                .forEach(
                        (name, symbol) ->
                                own.put(KindNames.SEMANTIC + "." + name, type(symbol.type())));
        own.forEach(builder::addVar);
        builder.setTypeProvider(new Structs());
        compiler = builder.build();
    }

    Expression compile(String text) throws ExpressionException {
        try {
            var parsed = checked(text, compiler.parse(text));
            Checks.parsed(text, parsed);
            var ast = checked(text, compiler.check(parsed));
            Checks.typed(text, ast, components);
            return new Expression(
                    scope,
                    text,
                    type(ast.getResultType()),
                    ResultUnit.of(ast, scope.own()),
                    Uses.of(ast, names),
                    RUNTIME.createProgram(ast),
                    new Cost(ast));
        } catch (CelValidationException | CelEvaluationException refused) {
            throw new ExpressionException(0, message(refused.getMessage()));
        }
    }

    private CelAbstractSyntaxTree checked(String text, CelValidationResult result)
            throws ExpressionException, CelValidationException {
        if (result.hasError()) {
            CelIssue issue = result.getErrors().getFirst();
            throw new ExpressionException(offset(text, issue), message(issue.getMessage()));
        }
        return result.getAst();
    }

    /**
     * Converts the position of an issue (line and column) into characters from the beginning of the
     * text.
     */
    private static int offset(String text, CelIssue issue) {
        int begin = 0;
        for (int line = 1; line < issue.getSourceLocation().getLine(); line++) {
            begin = text.indexOf('\n', begin) + 1;
        }
        return Math.clamp(begin + issue.getSourceLocation().getColumn(), 0, text.length());
    }

    private String message(String issue) {
        if (issue.equals(NO_FIELD)) {
            return "`has(…)` found a declared name, expected a symbol that is not declared;"
                    + " write `'note' in semantic` for a declared symbol `note`";
        }
        Matcher undefined = UNDEFINED.matcher(issue);
        if (undefined.matches()) {
            return "unknown name `" + undefined.group(1) + "`; known here: " + fieldsOfLastStruct;
        }
        Matcher undeclared = UNDECLARED.matcher(issue);
        if (undeclared.matches()) {
            return "unknown name `"
                    + undeclared.group(1)
                    + "`; known are "
                    + String.join(", ", names);
        }
        Matcher input = INPUT.matcher(issue);
        if (input.matches()) {
            String found = input.group(1) == null ? input.group(2) : input.group(1);
            return found.equals("<EOF>")
                    ? "the expression ends too early"
                    : "`" + found.strip() + "` makes no sense here" + remedy(found.strip());
        }
        Matcher overload = NO_OVERLOAD.matcher(issue);
        return overload.matches()
                ? "`"
                        + overload.group(1).replace("_", "")
                        + "` does not go with "
                        + words(overload.group(2))
                : issue;
    }

    /** Returns what to write instead of a word of another language; empty for other words. */
    private static String remedy(String found) {
        return switch (found) {
            case "and" -> "; write `&&`";
            case "or" -> "; write `||`";
            case "=" -> "; write `==` to compare";
            default ->
                    isUnit(found)
                            ? "; numbers have no unit here, and properties are in SI units: write"
                                    + " `> 1`, not `> 1 "
                                    + found
                                    + "`"
                            : "";
        };
    }

    private static boolean isUnit(String found) {
        try {
            Unit.parse(found);
            return true;
        } catch (IllegalArgumentException other) {
            return false;
        }
    }

    /**
     * Translates the CEL names of types into the words of the documentation. For example, {@code
     * list(double)} becomes "list of numbers".
     */
    private static String words(String types) {
        return types.replaceAll("\\b(int|uint|double)\\b", "number")
                .replace("string", "text")
                .replace("bool", "truth")
                .replaceAll("\\bnull\\b", "no value")
                .replaceAll("list\\((\\w+)\\)", "list of $1s");
    }

    private static ExpressionType type(CelType type) throws ExpressionException {
        return switch (type.kind()) {
            case BOOL -> ExpressionType.TRUTH;
            case INT, UINT, DOUBLE -> ExpressionType.NUMBER;
            case STRING -> ExpressionType.TEXT;
            case LIST -> ExpressionType.LIST;
            case DYN -> ExpressionType.ANY;
            default ->
                    throw new ExpressionException(
                            0,
                            "gives a "
                                    + type.name()
                                    + ", expected true or false, a number, a text or a list");
        };
    }

    private Map<String, CelType> aspects(String owner, KindNames kind) {
        Map<String, CelType> aspects = new LinkedHashMap<>();
        Map<String, CelType> physics = new LinkedHashMap<>();
        for (String name : kind.physicsNames()) {
            var property = Objects.requireNonNull(kind.property(name));
            physics.put(
                    name, numbers(owner + KindNames.PHYSICS + "." + name, property.components()));
        }
        aspects.put(KindNames.PHYSICS, struct(owner + KindNames.PHYSICS, physics));
        if (!kind.physicalNames().isEmpty()) {
            Map<String, CelType> physical = new LinkedHashMap<>();
            kind.physicalNames()
                    .forEach(
                            (name, count) ->
                                    physical.put(
                                            name,
                                            switch (count) {
                                                case KindNames.TEXT -> SimpleType.STRING;
                                                case KindNames.TRUTH -> SimpleType.BOOL;
                                                default ->
                                                        numbers(
                                                                owner
                                                                        + KindNames.PHYSICAL
                                                                        + "."
                                                                        + name,
                                                                count);
                                            }));
            aspects.put(KindNames.PHYSICAL, struct(owner + KindNames.PHYSICAL, physical));
        }
        aspects.put(KindNames.SEMANTIC, MapType.create(SimpleType.STRING, SimpleType.DYN));
        return aspects;
    }

    private Map<String, CelType> body(KindNames kind) {
        Map<String, CelType> fields = aspects("body.", kind);
        fields.putAll(names());
        return fields;
    }

    private static Map<String, CelType> names() {
        Map<String, CelType> fields = new LinkedHashMap<>();
        KindNames.ITEM_NAMES.forEach(name -> fields.put(name, SimpleType.STRING));
        return fields;
    }

    private StructType struct(String name, Map<String, CelType> fields) {
        StructType type =
                StructType.create(
                        name,
                        ImmutableSet.copyOf(fields.keySet()),
                        field -> Optional.ofNullable(fields.get(field)));
        structs.put(name, type);
        return type;
    }

    private CelType numbers(String name, int count) {
        components.put(name, count);
        return count == 1 ? SimpleType.DOUBLE : NUMBERS;
    }

    private CelType type(Parameter parameter, CelType body) {
        return switch (parameter.type()) {
            case NUMBER -> numbers(parameter.name(), parameter.components());
            case TEXT -> SimpleType.STRING;
            case TRUTH -> SimpleType.BOOL;
            case ITEM -> body;
        };
    }

    private static CelType type(SymbolType type) {
        return switch (type) {
            case NUMBER -> SimpleType.DOUBLE;
            case TEXT -> SimpleType.STRING;
            case TRUTH -> SimpleType.BOOL;
            case LIST -> ListType.create(SimpleType.DYN);
        };
    }

    /** Provides the types of names to the CEL checker. */
    private final class Structs implements CelTypeProvider {
        @Override
        public ImmutableCollection<CelType> types() {
            return ImmutableList.copyOf(structs.values());
        }

        @Override
        public Optional<CelType> findType(String name) {
            StructType found = structs.get(name);
            if (found != null) {
                fieldsOfLastStruct = String.join(", ", new TreeSet<>(found.fieldNames()));
            }
            return Optional.ofNullable(found);
        }
    }
}
