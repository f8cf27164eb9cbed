/* Python's calls of compiled kernels: arguments become words of 8 bytes, and what a kernel returns an object of Python.

   No header is needed: of Python only what its stable interface has, of numpy's arrays the layout that all its versions
   share (objects.py looks whether it does before it calls). What is not of the kind that was compiled, and what the
   kernel could not do, goes to the second of the two objects that a call is made of; the first is its description. */

typedef long long word;
typedef struct object { word count; void *type; } object;
typedef struct { object head; char *data; int dimensions; word *shape, *strides; object *base; void *item; int flags; } array;
typedef struct { const char *name; void *call; int flags; const char *doc; } method;

extern char PyFloat_Type[], PyLong_Type[], PyBool_Type[], _Py_TrueStruct[];
extern char *PyBytes_AsString(object *);
extern object *PyTuple_GetItem(object *, word), *PyTuple_New(word), *Py_BuildValue(const char *, ...);
extern int PyTuple_SetItem(object *, word, object *);
extern word PyTuple_Size(object *), PyLong_AsLongLong(object *);
extern double PyFloat_AsDouble(object *);
extern object *PyFloat_FromDouble(double), *PyLong_FromLongLong(word), *PyBool_FromLong(long);
extern object *PyNumber_Index(object *), *PyObject_Vectorcall(object *, object *const *, unsigned long, object *);
extern object *PyErr_Occurred(void);
extern void PyErr_Clear(void), Py_DecRef(object *);
extern object *PyCMethod_New(method *, object *, object *, object *);

/* What a description is made of, as objects.py writes it. */
enum { NUMBER, WHOLE, TRUTH, BLOCK, GROUP, NOTHING };
enum { CONTIGUOUS_AND_ALIGNED = 0x101, MOST_WORDS = 160, MOST_RESULTS = 16, FASTCALL = 0x80 };
typedef struct { word entry, block_type, float_type, whole_type, count, kinds[]; } description;

/* Write the words of an argument; return where the next go, or 0 where it is of another kind. */
static word *pack(const description *about, const word **kind, object *given, word *words, word *end)
{
    union { double number; word whole; } both;
    void *type = given->type;
    if (words >= end) return 0;
    switch (*(*kind)++) {
    case NUMBER:
        if (type != PyFloat_Type && type != (void *)about->float_type) return 0;
        both.number = PyFloat_AsDouble(given);
        *words++ = both.whole;
        return words;
    case WHOLE:
        if (type == (void *)about->whole_type) {
            object *plain = PyNumber_Index(given);
            if (!plain) { PyErr_Clear(); return 0; }
            *words = PyLong_AsLongLong(plain);
            Py_DecRef(plain);
        } else if (type == PyLong_Type) {
            *words = PyLong_AsLongLong(given);
        } else return 0;
        if (*words++ == -1 && PyErr_Occurred()) { PyErr_Clear(); return 0; }
        return words;
    case TRUTH:
        if (type != PyBool_Type) return 0;
        *words++ = (void *)given == _Py_TrueStruct;
        return words;
    case BLOCK: {
        const array *block = (array *)given;
        word dimensions = *(*kind)++, item = *(*kind)++;
        if (type != (void *)about->block_type || block->dimensions != dimensions || block->item != (void *)item
            || (block->flags & CONTIGUOUS_AND_ALIGNED) != CONTIGUOUS_AND_ALIGNED || words + dimensions >= end) return 0;
        *words++ = (word)block->data;
        for (word i = 0; i < dimensions; i++) *words++ = block->shape[i];
        return words;
    }
    case GROUP: {
        word made = *(*kind)++, count = *(*kind)++;
        if (type != (void *)made || PyTuple_Size(given) != count) return 0;
        for (word i = 0; i < count && words; i++) words = pack(about, kind, PyTuple_GetItem(given, i), words, end);
        return words;
    }
    }
    return 0;
}

static object *unpack(const word **kind, const word **words)
{
    union { double number; word whole; } both;
    switch (*(*kind)++) {
    case NUMBER: both.whole = *(*words)++; return PyFloat_FromDouble(both.number);
    case WHOLE: return PyLong_FromLongLong(*(*words)++);
    case TRUTH: return PyBool_FromLong(*(*words)++ != 0);
    case GROUP: {
        word count = *(*kind)++;
        object *found = PyTuple_New(count);
        for (word i = 0; i < count && found; i++) {
            object *item = unpack(kind, words);
            if (item) PyTuple_SetItem(found, i, item);
            else { Py_DecRef(found); found = 0; }
        }
        return found;
    }
    default: return Py_BuildValue("");
    }
}

static object *call(object *self, object *const *given, word count)
{
    const description *about = (const description *)PyBytes_AsString(PyTuple_GetItem(self, 0));
    const word *kind = about->kinds;
    word words[MOST_WORDS], results[MOST_RESULTS], *next = words;
    if (count == about->count) {
        for (word i = 0; i < count && next; i++) next = pack(about, &kind, given[i], next, words + MOST_WORDS);
        if (next && !((int (*)(word *, word *))about->entry)(words, results)) {
            const word *found = results;
            return unpack(&kind, &found);
        }
    }
    return PyObject_Vectorcall(PyTuple_GetItem(self, 1), given, count, 0);
}

static method kernel = {"kernel", call, FASTCALL, 0};

/* Return what Python calls: of a description and what is called otherwise. */
object *cdpr_make(object *self) { return PyCMethod_New(&kernel, self, 0, 0); }
