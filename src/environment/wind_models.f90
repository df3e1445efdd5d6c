!> The models of the thermosphere's wind by name. A new one: its own file, a type that extends
!> `wind_model_t`, and here its name in the list with its case below.
module gracecg_environment_wind_models
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail_unknown_name
    use gracecg_environment_wind, only: wind_model_t, constant_wind_t, tabulated_wind_t, embedded_wind, read_wind
    implicit none
    private
    public :: WIND_MODELS, new_wind_model

    !> The names; besides them 'file', a table
    character(16), parameter :: WIND_MODELS(3) = [character(16) :: 'hwm93', 'hwm93-smooth', 'constant']

contains

    !> The model of a name, or of a file. Fails when neither is known, and as the file's reader.
    subroutine new_wind_model(name, east, north, file, model, error)
        character(*), intent(in) :: name            !! One of WIND_MODELS, or 'file'
        real(dp), intent(in) :: east, north         !! If 'constant', m/s
        character(*), intent(in) :: file            !! Path of the table, if 'file'
        class(wind_model_t), allocatable, intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        type(tabulated_wind_t) :: table

        select case (name)
        case ('hwm93', 'hwm93-smooth')
            allocate (model, source=embedded_wind(smooth=name == 'hwm93-smooth'))
        case ('constant')
            allocate (model, source=constant_wind_t(east, north))
        case ('file')
            call read_wind(trim(file), table, error)
            if (.not. allocated(error)) allocate (model, source=table)
        case default
            call fail_unknown_name(error, 'wind model', name, [character(16) :: WIND_MODELS, 'file'])
        end select
    end subroutine new_wind_model
end module gracecg_environment_wind_models
