"""Records in place (`in_place`) as the compiler has them: a type, its fields, and how each is read."""

from __future__ import annotations

import zlib
from typing import Any

from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import lower_builtin, lower_getattr_generic, register_model, type_callable

from benchtool.emulator.in_place import in_place, renewed, value_of


class InPlace(types.Type):
    """Type of a record in place. Its name is short, which names of compiled functions are made of."""

    def __init__(self, value: Any) -> None:
        self.value = value
        crc = zlib.crc32(value.name.encode())
        name = f"{value.instance_class.__name__}_{crc:08x}"
        super().__init__(name=name)


def _of_field(value: Any, index: int) -> types.Type:
    field = value[index]
    return InPlace(field) if isinstance(field, types.BaseNamedTuple) else field


@register_model(InPlace)
class _InPlaceModel(models.PrimitiveModel):
    def __init__(self, manager: Any, in_place_type: InPlace) -> None:
        pointer = manager.lookup(in_place_type.value).get_value_type().as_pointer()
        super().__init__(manager, in_place_type, pointer)  # type: ignore[no-untyped-call]


@infer_getattr
class _Fields(AttributeTemplate):
    key = InPlace

    def generic_resolve(  # type: ignore[override]
        self, record: InPlace, name: str
    ) -> types.Type | None:
        if name not in record.value.fields:
            return None
        return _of_field(record.value, record.value.fields.index(name))


@lower_getattr_generic(InPlace)  # type: ignore[untyped-decorator]
def _read(context: Any, builder: Any, record: InPlace, pointer: Any, name: str) -> Any:
    index = record.value.fields.index(name)
    at = cgutils.gep_inbounds(builder, pointer, 0, index)
    return at if isinstance(record.value[index], types.BaseNamedTuple) else builder.load(at)


@type_callable(in_place)
def _type_in_place(context: Any) -> Any:
    def typer(record: types.Type) -> types.Type | None:
        return InPlace(record) if isinstance(record, types.BaseNamedTuple) else None

    return typer


@lower_builtin(in_place, types.BaseNamedTuple)  # type: ignore[untyped-decorator]
def _lower_in_place(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (record,) = signature.args
    pointer = cgutils.alloca_once(builder, context.get_value_type(record))
    _store(builder, record, arguments[0], pointer)
    return pointer


@type_callable(value_of)
def _type_whole(context: Any) -> Any:
    def typer(record: types.Type) -> types.Type | None:
        return record.value if isinstance(record, InPlace) else None

    return typer


@lower_builtin(value_of, InPlace)  # type: ignore[untyped-decorator]
def _lower_whole(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    (record,) = signature.args
    return _loaded(context, builder, record.value, arguments[0])


@type_callable(renewed)
def _type_renewed(context: Any) -> Any:
    def typer(part: types.Type, before: types.Type, now: types.Type) -> types.Type | None:
        return before if isinstance(before, InPlace) and before.value == now else None

    return typer


@lower_builtin(renewed, types.Any, InPlace, types.BaseNamedTuple)  # type: ignore[untyped-decorator]
def _lower_renewed(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    part, before, _ = signature.args
    _, pointer, now = arguments
    if not isinstance(part, types.NoneType):
        _store(builder, before.value, now, pointer)
    return pointer


def _store(builder: Any, record: Any, value: Any, pointer: Any) -> None:
    """Store a value number by number, as the compiler of numbers does better with these."""
    for index, field in enumerate(record):
        part, at = builder.extract_value(value, index), cgutils.gep_inbounds(builder, pointer, 0, index)
        if isinstance(field, types.BaseNamedTuple):
            _store(builder, field, part, at)
        else:
            builder.store(part, at)


def _loaded(context: Any, builder: Any, record: Any, pointer: Any) -> Any:
    value = cgutils.get_null_value(context.get_value_type(record))
    for index, field in enumerate(record):
        at = cgutils.gep_inbounds(builder, pointer, 0, index)
        nested = isinstance(field, types.BaseNamedTuple)
        part = _loaded(context, builder, field, at) if nested else builder.load(at)
        value = builder.insert_value(value, part, index)
    return value
