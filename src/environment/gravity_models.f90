!> The models of the Earth's gravity by name. A new one: its own file, a type that extends
!> `gravity_model_t`, and here its name in the list with its case below.
module gracecg_environment_gravity_models
    use gracecg_base_error, only: error_t, fail_unknown_name
    use gracecg_environment_geopotential, only: gravity_model_t, geopotential_t, point_mass_gravity_t, egm96
    use gracecg_environment_gfc_file, only: read_gfc
    implicit none
    private
    public :: GRAVITY_MODELS, new_gravity_model

    !> The names; besides them 'file', a model in ICGEM format
    character(16), parameter :: GRAVITY_MODELS(2) = [character(16) :: 'egm96', 'point-mass']

contains

    !> The model of a name, or of a file. Fails when neither is known, and as the model does.
    subroutine new_gravity_model(name, degree, order, file, model, error)
        character(*), intent(in) :: name            !! One of GRAVITY_MODELS, or 'file'
        integer, intent(in) :: degree, order        !! Up to which a sum of harmonics goes
        character(*), intent(in) :: file            !! Path of the .gfc file, if 'file'
        class(gravity_model_t), allocatable, intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        type(geopotential_t) :: geopotential

        select case (name)
        case ('egm96')
            call egm96(degree, order, geopotential, error)
            if (.not. allocated(error)) allocate (model, source=geopotential)
        case ('point-mass')
            allocate (point_mass_gravity_t :: model)
        case ('file')
            call read_gfc(trim(file), degree, order, geopotential, error)
            if (.not. allocated(error)) allocate (model, source=geopotential)
        case default
            call fail_unknown_name(error, 'gravity model', name, [character(16) :: GRAVITY_MODELS, 'file'])
        end select
    end subroutine new_gravity_model
end module gracecg_environment_gravity_models
