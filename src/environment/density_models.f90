!> The models of the thermosphere's density by name. A new one: its own file, a type that extends
!> `density_model_t`, and here its name in the list with its case below.
module gracecg_environment_density_models
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail_unknown_name
    use gracecg_environment_time, only: utc_t
    use gracecg_environment_space_weather, only: space_weather_source_t
    use gracecg_environment_thermosphere, only: density_model_t
    use gracecg_environment_dtm, only: dtm_t, new_dtm, DTM_EDITIONS
    use gracecg_environment_exponential_density, only: exponential_density_t, new_exponential_density
    implicit none
    private
    public :: DENSITY_MODELS, new_density_model, density_settings_t

    !> Names of the density models
    character(16), parameter :: DENSITY_MODELS(4) = [character(16) :: DTM_EDITIONS, 'exponential']

    !> What the models are made of; each takes its own.
    type :: density_settings_t
        type(space_weather_source_t) :: space_weather = space_weather_source_t()   !! Solar flux and geomagnetic activity
        real(dp) :: reference_density = 4e-12_dp        !! Exponential model, kg/m^3
        real(dp) :: reference_height = 466e3_dp         !! m
        real(dp) :: scale_height = 65e3_dp              !! m
    end type density_settings_t

contains

    !> The model of a name at a time. Fails for a name that is not known, and as the model does.
    subroutine new_density_model(name, utc, settings, model, error)
        character(*), intent(in) :: name        !! One of DENSITY_MODELS
        type(utc_t), intent(in) :: utc          !! Of the solar and geomagnetic activity
        type(density_settings_t), intent(in) :: settings
        class(density_model_t), allocatable, intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        type(dtm_t) :: dtm
        type(exponential_density_t) :: exponential
        real(dp) :: f107, f107_mean, kp, kp_6h_before

        select case (name)
        case (DTM_EDITIONS(1), DTM_EDITIONS(2), DTM_EDITIONS(3))
            call settings%space_weather%indices_at(utc, f107, f107_mean, kp, error, kp_6h_before)
            if (.not. allocated(error)) call new_dtm(name, f107, f107_mean, kp, dtm, error, kp_6h_before)
            if (.not. allocated(error)) allocate (model, source=dtm)
        case ('exponential')
            call new_exponential_density(settings%reference_density, settings%reference_height, &
                                         settings%scale_height, exponential, error)
            if (.not. allocated(error)) allocate (model, source=exponential)
        case default
            call fail_unknown_name(error, 'density model', name, DENSITY_MODELS)
        end select
    end subroutine new_density_model
end module gracecg_environment_density_models
