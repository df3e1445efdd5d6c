!> The models of the geomagnetic field by name. A new one: its own file, a type that extends
!> `geomagnetic_model_t`, and here its name in the list with its case below.
module gracecg_environment_geomagnetic_models
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail_unknown_name
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t, igrf_t, igrf
    use gracecg_environment_shc_file, only: read_shc
    implicit none
    private
    public :: GEOMAGNETIC_MODELS, new_geomagnetic_model

    !> The names; besides them 'file', a model in the format SHC
    character(16), parameter :: GEOMAGNETIC_MODELS(2) = [character(16) :: 'igrf95', 'igrf14']

contains

    !> The model of a name, or of a file, at a date. Fails when neither is known, and as the model
    !> does: mostly for a date that it does not cover.
    subroutine new_geomagnetic_model(name, decimal_year, file, model, error)
        character(*), intent(in) :: name            !! One of GEOMAGNETIC_MODELS, or 'file'
        real(dp), intent(in) :: decimal_year        !! Year with decimals
        character(*), intent(in) :: file            !! Path of the .shc file, if 'file'
        class(geomagnetic_model_t), allocatable, intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        type(igrf_t) :: harmonics

        select case (name)
        case ('igrf95', 'igrf14')
            call igrf(name, decimal_year, harmonics, error)
            if (.not. allocated(error)) allocate (model, source=harmonics)
        case ('file')
            call read_shc(trim(file), decimal_year, harmonics, error)
            if (.not. allocated(error)) allocate (model, source=harmonics)
        case default
            call fail_unknown_name(error, 'geomagnetic field', name, &
                                   [character(16) :: GEOMAGNETIC_MODELS, 'file'])
        end select
    end subroutine new_geomagnetic_model
end module gracecg_environment_geomagnetic_models
